#include "apps/commands.hpp"

namespace struna::apps {

void add_frf(CLI::App& app) { (void)app; }

}  // namespace struna::apps
