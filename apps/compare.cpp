#include "apps/commands.hpp"

namespace struna::apps {

void add_compare(CLI::App& app) { (void)app; }

}  // namespace struna::apps
