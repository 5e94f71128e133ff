#include "ident/mode_file.hpp"
