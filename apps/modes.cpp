#include "apps/commands.hpp"

namespace struna::apps {

void add_modes(CLI::App& app) { (void)app; }

}  // namespace struna::apps
