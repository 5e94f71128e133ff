#include "apps/report.hpp"
