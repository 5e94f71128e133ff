#include "ident/comparison.hpp"
