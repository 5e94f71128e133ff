#include "ident/mode.hpp"
