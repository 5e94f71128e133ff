#include "fem/scene.hpp"
