#include "fem/eigenmodes.hpp"
