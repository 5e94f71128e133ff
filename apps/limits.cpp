#include "apps/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/limit_map.hpp"
#include "apps/limit_page.hpp"
#include "apps/limit_svg.hpp"
#include "apps/output_folder.hpp"
#include "ident/atomic_file.hpp"

namespace struna::apps {
namespace {

struct LimitArguments {
  std::vector<std::string> maps;
  int seeds = 0;
  int first_seed = 1;
  std::string to;
};

std::vector<KnownLimit> chosen_limits(const LimitArguments& arguments) {
  const std::vector<KnownLimit> all = known_limits();
  if (arguments.maps.empty()) return all;
  std::string names;
  for (const auto& known : all) names += (names.empty() ? "" : ", ") + known.name;
  std::vector<KnownLimit> chosen;
  for (const auto& name : arguments.maps) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const KnownLimit& known) { return known.name == name; });
    if (found == all.end()) throw UsageError(fmt::format("--map: must be one of {}, got '{}'", names, name));
    chosen.push_back(*found);
  }
  return chosen;
}

void print_summary(const std::vector<LimitMap>& maps) {
  Table table{{"map", "right", "flagged", "uncertain", "wrong", "flagged", "refused"}, {}};
  for (const auto& map : maps) {
    const LimitCount count = count_of(map);
    table.rows.push_back({map.name, std::to_string(count.right), count.false_alarm_text(),
                          std::to_string(count.uncertain), std::to_string(count.wrong), count.flagged_text(),
                          std::to_string(count.refused)});
  }
  print(table);
  for (const auto& map : maps) print(fmt::format("{}: {}", map.name, sentence_of(map)));
}

void run_limits(const LimitArguments& arguments, const std::string& command) {
  const std::vector<KnownLimit> chosen = chosen_limits(arguments);
  check_folder(arguments.to);
  LimitRun run;
  run.seeds = arguments.seeds;
  run.first_seed = arguments.first_seed;
  run.progress = [](const std::string& message) { progress(message); };
  std::vector<LimitMap> maps;
  for (const auto& known : chosen) {
    run.progress("limits: " + known.name);
    maps.push_back(known.map(run));
  }
  print_summary(maps);
  fill_folder(arguments.to, [&](const std::string& staging) {
    ident::write_atomically(staging + "/limits.csv", limits_csv(maps));
    ident::write_atomically(staging + "/index.html", limit_page(maps, command));
    for (const auto& map : maps)
      ident::write_atomically(fmt::format("{}/limits_{}.svg", staging, map.name), limit_svg(map));
  });
}

std::string command_line(const LimitArguments& arguments) {
  std::string line = "struna limits";
  for (const auto& name : arguments.maps) line += " --map " + name;
  if (arguments.seeds > 0) line += fmt::format(" --seeds {}", arguments.seeds);
  if (arguments.first_seed != 1) line += fmt::format(" --first-seed {}", arguments.first_seed);
  return line + " -o " + arguments.to;
}

}  // namespace

void add_limits(CLI::App& app) {
  const auto arguments = std::make_shared<LimitArguments>();
  CLI::App* const limits =
      app.add_subcommand("limits", "where each method stops working, and whether it says so");
  limits->add_option("-o", arguments->to, "folder for limits.csv, index.html and an SVG per map")->required();
  std::string names;
  for (const auto& known : known_limits()) names += (names.empty() ? "" : ", ") + known.name;
  limits->add_option("--map", arguments->maps, names + "; may be repeated; default: all")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  limits->add_option("--seeds", arguments->seeds, "draws of the noise at each place; default: each map's own")
      ->check(CLI::Range(1, 1000));
  limits->add_option("--first-seed", arguments->first_seed, "of these draws (1): another number, fresh draws")
      ->check(CLI::Range(1, 1000000));
  limits->footer(
      "Every map uses a method over a grid of its parameters, where the truth is known, and counts right "
      "and\n"
      "wrong results, with and without a flag.\n"
      "Examples:\n"
      "  struna limits -o out\n"
      "  struna limits --map circle --map modes --seeds 20 -o out");
  limits->callback([arguments] { run_limits(*arguments, command_line(*arguments)); });
}

}  // namespace struna::apps
