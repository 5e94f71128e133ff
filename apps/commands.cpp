#include "apps/commands.hpp"

#include <cstdio>
#include <new>

#include "apps/console.hpp"

namespace struna::apps {
namespace {

int fail(int exit_code, const std::string& message) {
  std::fprintf(stderr, "struna: %s\n", one_line(message).c_str());
  return exit_code;
}

/// The command that was named, for the hint ("struna frf --help").
std::string help_hint(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return "(see struna " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help)";
}

void add_commands(CLI::App& app) {
  app.set_version_flag("--version", "struna " STRUNA_VERSION);
  app.add_flag_callback(
      "--quiet", [] { set_quiet(true); }, "no progress and no tables; warnings stay");
  app.require_subcommand(1);
  app.fallthrough();
  app.get_formatter()->column_width(36);
  app.footer(
      "Example, from records to report in one command:\n"
      "  struna identify sample_data/curved_wire/study.toml -o out\n\n"
      "Exit code: 0 done; 1 input or data at fault, one line tells what and where; 2 wrong usage.");

  add_frf(app);
  add_modes(app);
  add_fit(app);
  add_predict(app);
  add_compare(app);
  add_identify(app);
  add_eigen(app);
  add_simulate(app);
  add_tradeoff(app);
}

}  // namespace

int run(int argc, const char* const* argv) {
  CLI::App app("struna: system identification of vibrating wires and slender structures", "struna");
  try {
    add_commands(app);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return fail(2, std::string(error.what()) + " " + help_hint(app));
  } catch (const UsageError& error) {
    return fail(2, std::string(error.what()) + " " + help_hint(app));
  } catch (const Error& error) {
    return fail(1, error.what());
  } catch (const std::bad_alloc&) {
    return fail(1, "not enough memory for this input; a shorter record or a coarser resolution needs less");
  } catch (const std::exception& error) {
    return fail(1, std::string("unexpected fault, please report it: ") + error.what());
  }
  return 0;
}

}  // namespace struna::apps
