#include "ident/parameter_file.hpp"
