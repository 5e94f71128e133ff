#include "ident/csv.hpp"
