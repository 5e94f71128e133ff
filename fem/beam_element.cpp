#include "fem/beam_element.hpp"
