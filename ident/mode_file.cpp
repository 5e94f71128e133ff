#include "ident/mode_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/csv.hpp"

namespace struna::ident {
namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// What the constants' unit has after the circle form's: C/(omega_r^2 (1 + i eta) - omega^2), C/(i omega -
/// p).
std::string per_time(fem::Damping damping) {
  return damping == fem::Damping::structural ? "/s^2" : "/s";
}

/// A number, or an empty field for one that is not known (NaN).
std::string field(double value) {
  return std::isnan(value) ? "" : fmt::format("{:.10g}", value);
}

/// One row of a modes file, by column name; columns and fields may be missing where `optional` is asked.
class Row {
 public:
  Row(const CsvReader& csv, const std::vector<std::string_view>& fields) : csv_(csv), fields_(fields) {}

  double required(const std::string& name) const { return csv_.number(fields_, csv_.column(name)); }
  double optional(const std::string& name) const {
    const int column = csv_.find(name);
    return column < 0 || text(column).empty() ? not_known : csv_.number(fields_, column);
  }
  std::string text(const std::string& name) const {
    const int column = csv_.find(name);
    return column < 0 ? "" : std::string(text(column));
  }
  Error error(const std::string& message) const { return {csv_.file(), csv_.line(), message}; }

 private:
  std::string_view text(int column) const { return fields_[static_cast<std::size_t>(column)]; }

  const CsvReader& csv_;
  const std::vector<std::string_view>& fields_;
};

std::vector<ModeFlag> read_flags(const Row& row) {
  std::vector<ModeFlag> flags;
  std::string words = row.text("flags");
  while (!words.empty()) {
    const std::size_t end = std::min(words.find(';'), words.size());
    try {
      flags.push_back(mode_flag(words.substr(0, end)));
    } catch (const Error& fault) {
      throw row.error(fault.reason());
    }
    words.erase(0, end + 1);
  }
  return flags;
}

/// Loss factor from either column; zeta = eta/2 (eta = 2 zeta in viscous fits).
void read_damping(const Row& row, Mode& mode) {
  mode.loss_factor = row.optional("loss_factor");
  mode.damping_ratio = row.optional("damping_ratio");
  if (std::isnan(mode.loss_factor) && std::isnan(mode.damping_ratio))
    throw row.error("needs a loss_factor or a damping_ratio");
  if (std::isnan(mode.loss_factor)) mode.loss_factor = 2.0 * mode.damping_ratio;
  if (std::isnan(mode.damping_ratio)) mode.damping_ratio = 0.5 * mode.loss_factor;
  mode.loss_factor_sigma = row.optional("loss_factor_sigma");
  if (!(mode.loss_factor > 0.0))
    throw row.error(fmt::format("loss_factor is {}: it must be positive", mode.loss_factor));
}

/// Where the file has no half-power frequencies: those that eq. (13) makes of frequency and loss factor.
double half_power(const Row& row, const std::string& name, const Mode& mode, double side) {
  const double written = row.optional(name);
  return std::isnan(written)
             ? mode.natural_frequency_hz * std::sqrt(std::max(0.0, 1.0 + side * mode.loss_factor))
             : written;
}

/// A whole number from 0 on; 0 where the file has none.
int count_of(const Row& row, const std::string& name) {
  const double value = row.optional(name);
  if (std::isnan(value)) return 0;
  if (value < 0.0 || value > 1000.0 || value != std::floor(value))
    throw row.error(fmt::format("{} is {}: it must be a whole number from 0 to 1000", name, value));
  return static_cast<int>(value);
}

Mode read_mode(const Row& row, const std::vector<std::string>& outputs) {
  Mode mode;
  mode.natural_frequency_hz = row.required("natural_frequency");
  if (!(mode.natural_frequency_hz > 0.0))
    throw row.error(
        fmt::format("natural_frequency is {} Hz: it must be positive", mode.natural_frequency_hz));
  mode.natural_frequency_sigma = row.optional("natural_frequency_sigma");
  read_damping(row, mode);
  mode.lower_half_power_hz = half_power(row, "lower_half_power", mode, -1.0);
  mode.upper_half_power_hz = half_power(row, "upper_half_power", mode, 1.0);
  mode.flags = read_flags(row);
  mode.circle_natural_frequency_hz = row.optional("circle_natural_frequency");
  mode.circle_loss_factor = row.optional("circle_loss_factor");
  mode.resolves_from = row.optional("resolves_from");
  mode.stable_orders = count_of(row, "stable_orders");
  mode.orders = count_of(row, "orders");
  const auto count = static_cast<Eigen::Index>(outputs.size());
  mode.modal_constant.resize(count);
  mode.modal_constant_sigma.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::string prefix = outputs[static_cast<std::size_t>(k)] + "_constant_";
    mode.modal_constant[k] = {row.required(prefix + "re"), row.required(prefix + "im")};
    mode.modal_constant_sigma[k] = row.optional(prefix + "sigma");
  }
  return mode;
}

/// Hand-made tables in other units would be read wrongly without a word.
void require_units(const CsvReader& csv) {
  for (const auto& column : csv.header()) {
    const bool frequency = column.name.starts_with("natural_frequency") ||
                           column.name.ends_with("half_power") || column.name == "circle_natural_frequency";
    const bool ratio = column.name.starts_with("loss_factor") || column.name == "damping_ratio" ||
                       column.name == "circle_loss_factor" || column.name == "resolves_from";
    if (frequency && column.unit != "Hz")
      throw Error(csv.file(), 1,
                  fmt::format("the unit of {} is '{}': it must be Hz", column.name, column.unit));
    if (ratio && column.unit != "-" && !column.unit.empty())
      throw Error(
          csv.file(), 1,
          fmt::format("the unit of {} is '{}': it must be - (a plain ratio)", column.name, column.unit));
  }
}

/// Outputs, form and damping from the constants' columns and their unit.
ModeSet read_header(const CsvReader& csv) {
  static const std::string ending = "_constant_re";
  require_units(csv);
  ModeSet set;
  for (const auto& column : csv.header()) {
    if (!column.name.ends_with(ending)) continue;
    const bool structural = column.unit.ends_with(per_time(fem::Damping::structural));
    const fem::Damping damping = structural ? fem::Damping::structural : fem::Damping::viscous;
    if (!column.unit.ends_with(per_time(damping)))
      throw Error(
          csv.file(), 1,
          fmt::format("the unit of '{}' is '{}': it must end in /s^2 (structural) or /s (viscous damping)",
                      column.name, column.unit));
    if (!set.outputs.empty() && damping != set.damping)
      throw Error(csv.file(), 1, "the units of the constants mix structural (/s^2) and viscous (/s) damping");
    set.damping = damping;
    set.outputs.push_back(column.name.substr(0, column.name.size() - ending.size()));
    set.units.push_back(column.unit.substr(0, column.unit.size() - per_time(damping).size()));
    set.form = kind_of_unit(set.units.back());
  }
  return set;
}

}  // namespace

std::string flag_words(const std::vector<ModeFlag>& flags) {
  std::string words;
  for (const ModeFlag flag : flags) words += (words.empty() ? "" : ";") + to_string(flag);
  return words;
}

void write_modes(const ModeSet& set, const std::string& file) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(
      out,
      "mode,natural_frequency [Hz],natural_frequency_sigma [Hz],lower_half_power [Hz],upper_half_power [Hz],"
      "loss_factor [-],loss_factor_sigma [-],damping_ratio [-],flags,circle_natural_frequency [Hz],"
      "circle_loss_factor [-]");
  for (std::size_t k = 0; k < set.outputs.size(); ++k)
    fmt::format_to(out, ",{0}_constant_re [{1}],{0}_constant_im [{1}],{0}_constant_sigma [{1}]",
                   set.outputs[k], set.units[k] + per_time(set.damping));
  fmt::format_to(out, ",resolves_from [-],stable_orders [-],orders [-]\n");
  for (std::size_t r = 0; r < set.modes.size(); ++r) {
    const Mode& mode = set.modes[r];
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{},{},{}", r + 1, field(mode.natural_frequency_hz),
                   field(mode.natural_frequency_sigma), field(mode.lower_half_power_hz),
                   field(mode.upper_half_power_hz), field(mode.loss_factor), field(mode.loss_factor_sigma),
                   field(mode.damping_ratio), flag_words(mode.flags), field(mode.circle_natural_frequency_hz),
                   field(mode.circle_loss_factor));
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(set.outputs.size()); ++k)
      fmt::format_to(out, ",{},{},{}", field(mode.modal_constant[k].real()),
                     field(mode.modal_constant[k].imag()),
                     field(mode.modal_constant_sigma.size() > k ? mode.modal_constant_sigma[k] : not_known));
    fmt::format_to(out, ",{}", field(mode.resolves_from));
    if (mode.orders > 0)
      fmt::format_to(out, ",{},{}\n", mode.stable_orders, mode.orders);
    else
      fmt::format_to(out, ",,\n");
  }
  write_atomically(file, std::string_view(text.data(), text.size()));
}

ModeSet read_modes(const std::string& file) {
  CsvReader csv(file);
  ModeSet set = read_header(csv);
  csv.column("natural_frequency");
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    set.modes.push_back(read_mode(Row(csv, fields), set.outputs));
    const std::size_t count = set.modes.size();
    if (count > 1 && set.modes[count - 1].natural_frequency_hz < set.modes[count - 2].natural_frequency_hz)
      throw Error(file, csv.line(),
                  "natural frequencies must not fall from one row to the next: sort the rows");
  }
  if (set.modes.empty()) throw Error(file, 0, "has no modes below its header");
  return set;
}

}  // namespace struna::ident
