#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "fem/error.hpp"

int main(int argc, char** argv) {
  using namespace struna::apps;
  CLI::App app("struna: system identification of vibrating wires and slender structures", "struna");
  app.set_version_flag("--version", "struna " STRUNA_VERSION);
  app.add_flag_callback("--quiet", [] { set_quiet(true); }, "no progress and no tables; warnings stay");
  app.require_subcommand(1);
  app.fallthrough();

  add_frf(app);
  add_modes(app);
  add_fit(app);
  add_predict(app);
  add_compare(app);
  add_identify(app);
  add_eigen(app);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "struna: %s\n", error.what());
    return 1;
  }
  return 0;
}
