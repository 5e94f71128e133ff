#include "apps/commands.hpp"

namespace struna::apps {

void add_fit(CLI::App& app) { (void)app; }

}  // namespace struna::apps
