#include "ident/parameter_identification.hpp"
