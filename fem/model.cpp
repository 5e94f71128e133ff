#include "fem/model.hpp"
