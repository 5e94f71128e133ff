#include "ident/atomic_file.hpp"
