#include "ident/circle_fit.hpp"
