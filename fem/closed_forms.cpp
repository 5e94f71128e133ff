#include "fem/closed_forms.hpp"
