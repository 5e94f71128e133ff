#include "ident/transfer_function.hpp"
