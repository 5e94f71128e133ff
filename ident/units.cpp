#include "ident/units.hpp"
