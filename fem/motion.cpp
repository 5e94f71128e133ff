#include "fem/motion.hpp"
