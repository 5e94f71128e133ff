#include "apps/toml_table.hpp"
