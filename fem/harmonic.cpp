#include "fem/harmonic.hpp"
