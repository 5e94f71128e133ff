#include "apps/commands.hpp"

namespace struna::apps {

void add_identify(CLI::App& app) { (void)app; }

}  // namespace struna::apps
