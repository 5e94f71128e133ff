#include "fem/centreline.hpp"
