#include "ident/multi_mode.hpp"
