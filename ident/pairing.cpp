#include "ident/pairing.hpp"
