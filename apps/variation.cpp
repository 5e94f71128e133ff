#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "ident/mode_file.hpp"
#include "ident/mode_variation.hpp"

namespace struna::apps {
namespace {

struct VariationArguments {
  std::vector<std::string> files;
  std::string to;
};

/// "0.0047 % (p = 0.002)"; a dash where the errors explain the scatter.
std::string between_shown(const ident::Variation& v) {
  return v.exceeds_errors() ? fmt::format("{:.2g} % (p = {:.2g})", 100.0 * v.between / v.mean, v.probability)
                            : "-";
}

void run_variation(const VariationArguments& arguments) {
  std::vector<ident::ModeSet> sets;
  for (const std::string& file : arguments.files) sets.push_back(ident::read_modes(file));
  const std::vector<ident::ModeVariation> modes =
      blaming(arguments.files, [&] { return ident::mode_variation(sets); });
  const fem::Damping damping = sets.front().damping;
  if (!arguments.to.empty()) ident::write_mode_variation(modes, damping, arguments.to);

  const bool viscous = damping == fem::Damping::viscous;
  Table table{
      {"frequency [Hz]", "+-", "largest difference [%]", "between sets",
       viscous ? "damping ratio" : "loss factor", "+-", "largest difference [%]", "between sets", "in sets"},
      {}};
  long varying = 0, alone = 0;
  for (const ident::ModeVariation& mode : modes) {
    const ident::Variation &f = mode.frequency, &d = mode.damping;
    alone += mode.sets() == 1 ? 1 : 0;
    varying += f.exceeds_errors() || d.exceeds_errors() ? 1 : 0;
    table.rows.push_back({fmt::format("{:.6g}", f.mean), fmt::format("{:.2g}", f.mean_sigma),
                          fmt::format("{:.3g}", 100.0 * f.largest / f.mean), between_shown(f),
                          fmt::format("{:.4g}", d.mean), fmt::format("{:.2g}", d.mean_sigma),
                          fmt::format("{:.3g}", 100.0 * d.largest / d.mean), between_shown(d),
                          fmt::format("{} of {}", mode.sets(), sets.size())});
  }
  print(table);
  print(fmt::format(
      "{} modes in {} sets; {} vary by more than their standard errors explain (5 % do by chance), {} "
      "stand in one set only",
      modes.size(), sets.size(), varying, alone));
}

}  // namespace

void add_variation(CLI::App& app) {
  const auto arguments = std::make_shared<VariationArguments>();
  CLI::App* const command = app.add_subcommand(
      "variation",
      "modes identified apart (hit by hit, day by day): what changes beyond their standard errors");
  command->add_option("MODES.csv", arguments->files, "modes of the same structure, two files or more")
      ->type_name("")
      ->required()
      ->expected(2, -1);
  command->add_option("-o", arguments->to, "variation to write")
      ->type_name(written_file + std::string(".csv"));
  command->footer(
      "Example:\n"
      "  struna variation hit_1_modes.csv hit_2_modes.csv -o variation.csv");
  command->callback([arguments] { run_variation(*arguments); });
}

}  // namespace struna::apps
