#include "ident/transfer_function_file.hpp"
