#include "apps/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>

#include "apps/console.hpp"
#include "apps/toml_table.hpp"
#include "fem/error.hpp"

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

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& words) {
  const std::string nearest = nearest_word(word, words);
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

/// What is wrong with a command line that the parser refuses: a misspelt command or option is named with the
/// one that is probably meant, whatever the parser misses in consequence.
std::string usage_fault(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> left = app.remaining(true);
  const auto option = std::find_if(left.begin(), left.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word != "--";
  });
  const auto chosen = app.get_subcommands();
  if (chosen.empty() && !left.empty() && option != left.begin()) {
    const std::vector<std::string> commands = command_names(app);
    const std::string hint = did_you_mean(left.front(), commands);
    return fmt::format("unknown command '{}'", left.front()) +
           (hint.empty() ? fmt::format("; there are {}", fmt::join(commands, ", ")) : hint);
  }
  if (option != left.end()) {
    const CLI::App& command = chosen.empty() ? app : *chosen.front();
    std::vector<std::string> names = {"--help", "--quiet"};
    for (const CLI::Option* known : command.get_options())
      for (const std::string& name : known->get_lnames()) names.push_back("--" + name);
    const std::string name = option->substr(0, option->find('='));
    return fmt::format("unknown option {}", name) + did_you_mean(name, names);
  }
  if (chosen.empty()) return fmt::format("a command is needed: {}", fmt::join(command_names(app), ", "));
  return error.what();
}

bool writes(const CLI::Option& option) {
  return option.get_name() == "-o" || option.get_type_name().rfind(written_file, 0) == 0;
}

/// Also where nothing tells what a text is.
bool may_read(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return option.get_positional() || type.rfind(read_file, 0) == 0 || type == "TEXT";
}

/// Of several files to write, one that cannot be would leave the others behind.
void require_folders(const std::vector<std::pair<std::string, std::string>>& written) {
  if (written.size() < 2) return;
  for (const auto& [option, file] : written) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder))
      throw Error(file, 0, "cannot be written: there is no folder " + folder.string());
  }
}

/// No command writes over what it reads, told before anything is read.
void check_files(const CLI::App& command) {
  std::vector<std::pair<std::string, std::string>> written;
  std::vector<std::string> read;
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string> values = option->results();
    if (writes(*option)) {
      for (const auto& value : values) written.emplace_back(option->get_name(), value);
    } else if (may_read(*option)) {
      read.insert(read.end(), values.begin(), values.end());
    }
  }
  refuse_overwriting(written, read);
  require_folders(written);
}

void add_commands(CLI::App& app) {
  app.set_version_flag("--version", "struna " STRUNA_VERSION);
  app.add_flag_callback(
      "--quiet", [] { set_quiet(true); }, "no progress and no tables; warnings stay");
  app.require_subcommand(1);
  app.parse_complete_callback([&app] { check_files(*app.get_subcommands().front()); });
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
  add_variation(app);
  add_identify(app);
  add_eigen(app);
  add_simulate(app);
  add_tradeoff(app);
  add_limits(app);
}

}  // namespace

int run(int argc, const char* const* argv) {
  CLI::App app("struna: system identification of vibrating wires and slender structures", "struna");
  try {
    add_commands(app);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return fail(2, usage_fault(app, error) + " " + help_hint(app));
  } catch (const UsageError& error) {
    return fail(2, error.reason() + " " + help_hint(app));
  } catch (const Error& error) {
    return fail(1, error.reason());
  } catch (const std::bad_alloc&) {
    return fail(1, "not enough memory for this input; a shorter record or a coarser resolution needs less");
  } catch (const std::exception& error) {
    return fail(1, std::string("unexpected fault, please report it: ") + error.what());
  }
  return 0;
}

}  // namespace struna::apps
