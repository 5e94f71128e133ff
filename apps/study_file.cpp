#include "apps/study_file.hpp"
