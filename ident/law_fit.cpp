#include "ident/law_fit.hpp"
