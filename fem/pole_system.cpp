#include "fem/pole_system.hpp"
