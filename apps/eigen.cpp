#include "apps/commands.hpp"

namespace struna::apps {

void add_eigen(CLI::App& app) { (void)app; }

}  // namespace struna::apps
