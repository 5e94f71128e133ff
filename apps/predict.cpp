#include "apps/commands.hpp"

namespace struna::apps {

void add_predict(CLI::App& app) { (void)app; }

}  // namespace struna::apps
