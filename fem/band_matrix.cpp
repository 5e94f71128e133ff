#include "fem/band_matrix.hpp"
