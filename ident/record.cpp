#include "ident/record.hpp"
