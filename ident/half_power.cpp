#include "ident/half_power.hpp"
