#include "apps/scene_file.hpp"
