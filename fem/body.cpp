#include "fem/body.hpp"
