#include "ident/rayleigh_fit.hpp"
