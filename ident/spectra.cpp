#include "ident/spectra.hpp"
