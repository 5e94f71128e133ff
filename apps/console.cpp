#include "apps/console.hpp"
