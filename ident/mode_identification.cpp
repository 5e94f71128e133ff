#include "ident/mode_identification.hpp"
