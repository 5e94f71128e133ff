#include "apps/simulate_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/report_files.hpp"
#include "apps/report_page.hpp"
#include "ident/units.hpp"

namespace struna::apps {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

/// Time bins of a waveform's envelope, and of a contact map: more than a screen has points.
constexpr long envelope_bins = 2000;
constexpr long map_bins = 1000;
/// Samples shown one by one around the liveliest moment.
constexpr long excerpt_samples = 1500;

/// The record's channels and, where there is one, the base acceleration behind the motion.
ident::Record shown_record(const SimulationReportContent& content) {
  ident::Record shown = content.record;
  if (content.base_acceleration.size() != shown.samples.rows()) return shown;
  shown.channels.insert(shown.channels.begin() + 1, {"acceleration", ident::Quantity::acceleration, 0.0});
  shown.samples.resize(content.record.samples.rows(), content.record.samples.cols() + 1);
  shown.samples << content.record.samples.col(0), content.base_acceleration,
      content.record.samples.rightCols(content.record.samples.cols() - 1);
  return shown;
}

json envelope(const ident::Record& record) {
  const long per_bin = std::max(1L, (record.samples.rows() + envelope_bins - 1) / envelope_bins);
  const long bins = (record.samples.rows() + per_bin - 1) / per_bin;
  json channels = json::array();
  for (std::size_t k = 0; k < record.channels.size(); ++k) {
    VectorXd lo(bins), hi(bins);
    for (long bin = 0; bin < bins; ++bin) {
      const auto part = record.samples.col(static_cast<long>(k))
                            .segment(bin * per_bin, std::min(per_bin, record.samples.rows() - bin * per_bin));
      lo[bin] = part.minCoeff();
      hi[bin] = part.maxCoeff();
    }
    json channel = {{"name", record.channels[k].name}, {"unit", ident::si_unit(record.channels[k].quantity)}};
    channel["lo"] = numbers(lo, 5);
    if (per_bin > 1) channel["hi"] = numbers(hi, 5);
    channels.push_back(std::move(channel));
  }
  return {{"perBin", per_bin},
          {"interval", number(static_cast<double>(per_bin) * record.sample_interval)},
          {"channels", std::move(channels)}};
}

/// Where most happens: the deepest penetration, or without contact the largest output [s].
double liveliest_moment(const SimulationReportContent& content) {
  double moment = 0.0, deepest = 0.0;
  for (const auto& map : content.contacts) {
    if (map.penetration.size() == 0) continue;
    long bin = 0, point = 0;
    const double value = map.penetration.maxCoeff(&bin, &point);
    if (value <= deepest) continue;
    deepest = value;
    moment = (static_cast<double>(bin) + 0.5) * map.interval;
  }
  if (deepest > 0.0) return moment;
  long row = 0, column = 0;
  const long outputs = content.record.samples.cols() - 1;
  if (outputs > 0) content.record.samples.rightCols(outputs).cwiseAbs().maxCoeff(&row, &column);
  return static_cast<double>(row) * content.record.sample_interval;
}

json excerpt(const SimulationReportContent& content, const ident::Record& shown) {
  const long all = shown.samples.rows();
  const long count = std::min(all, excerpt_samples);
  const long middle = std::lround(liveliest_moment(content) / shown.sample_interval);
  const long first = std::clamp(middle - count / 2, 0L, all - count);
  json channels = json::array();
  for (std::size_t k = 0; k < shown.channels.size(); ++k) {
    json channel = {{"values", numbers(shown.samples.col(static_cast<long>(k)).segment(first, count), 6)}};
    if (content.measured) {
      const auto& beside = content.measured->record;
      for (std::size_t m = 1; m < beside.channels.size(); ++m) {
        if (beside.channels[m].name != shown.channels[k].name || beside.samples.rows() < first + count)
          continue;
        channel["measured"] = numbers(beside.samples.col(static_cast<long>(m)).segment(first, count), 6);
      }
    }
    channels.push_back(std::move(channel));
  }
  return {{"start", number(static_cast<double>(first) * shown.sample_interval)},
          {"interval", number(shown.sample_interval)},
          {"channels", std::move(channels)}};
}

/// The largest value of every `pool` rows.
MatrixXd pooled(const MatrixXd& values, long pool) {
  MatrixXd result((values.rows() + pool - 1) / pool, values.cols());
  for (long i = 0; i < result.rows(); ++i)
    result.row(i) =
        values.middleRows(i * pool, std::min(pool, values.rows() - i * pool)).colwise().maxCoeff();
  return result;
}

json contact_maps(const SimulationReportContent& content) {
  json maps = json::array();
  for (const auto& map : content.contacts) {
    const long pool = std::max(1L, (map.penetration.rows() + map_bins - 1) / map_bins);
    maps.push_back({{"inside", map.inside},
                    {"outside", map.outside},
                    {"gap", number(map.gap)},
                    {"arcLength", numbers(map.arc_length, 6)},
                    {"interval", number(map.interval * static_cast<double>(pool))},
                    {"penetration", numbers_by_row(pooled(map.penetration, pool), 4)},
                    {"force", numbers_by_row(pooled(map.force, pool), 4)}});
  }
  return maps;
}

/// Number of lines of the spectra at or below the highest frequency shown.
long lines_shown(const SimulationReportContent& content) {
  const VectorXd& f = content.transfer.spectra.frequency_hz;
  return std::upper_bound(f.begin(), f.end(), content.highest_hz) - f.begin();
}

struct Density {
  std::string name;
  std::string unit;
  VectorXd simulated, linear, measured;  ///< [unit^2/Hz] on the lines > 0; empty when there is none
};

/// On the simulation's lines: the measured record's are the same when both are equally long, else
/// interpolated.
VectorXd at_lines(const VectorXd& x, const VectorXd& y, const VectorXd& wanted) {
  VectorXd result(wanted.size());
  for (long i = 0; i < wanted.size(); ++i) {
    const long k =
        std::clamp<long>(std::lower_bound(x.begin(), x.end(), wanted[i]) - x.begin(), 1, x.size() - 1);
    const double share = std::clamp((wanted[i] - x[k - 1]) / (x[k] - x[k - 1]), 0.0, 1.0);
    result[i] = (1.0 - share) * y[k - 1] + share * y[k];
  }
  return result;
}

std::vector<Density> densities(const SimulationReportContent& content, const VectorXd& frequency) {
  const auto& spectra = content.transfer.spectra;
  std::vector<Density> list;
  for (std::size_t k = 0; k < spectra.outputs.size(); ++k) {
    const auto column = static_cast<long>(k);
    Density density{spectra.outputs[k].name, ident::si_unit(spectra.outputs[k].quantity), {}, {}, {}};
    density.simulated = spectra.output_auto.col(column).segment(1, frequency.size());
    if (content.linear_at_spectra) {
      for (const auto& output : content.linear_at_spectra->outputs) {
        if (output.name != density.name) continue;
        density.linear = output.value.head(frequency.size())
                             .cwiseAbs2()
                             .cwiseProduct(spectra.input_auto.segment(1, frequency.size()));
      }
    }
    if (content.measured) {
      const auto& other = content.measured->transfer.spectra;
      for (std::size_t m = 0; m < other.outputs.size(); ++m) {
        if (other.outputs[m].name != density.name) continue;
        density.measured =
            at_lines(other.frequency_hz, other.output_auto.col(static_cast<long>(m)), frequency);
      }
    }
    list.push_back(std::move(density));
  }
  return list;
}

json levels(const VectorXd& frequency, const VectorXd& density, const VectorXd& edge_hz) {
  if (density.size() == 0) return nullptr;
  return numbers(ident::half_octave_levels(frequency, density, edge_hz).rms, 5);
}

/// Amplitude densities in narrow lines, and half-octave levels from some lines above zero on.
json spectra_json(const SimulationReportContent& content) {
  const long shown = lines_shown(content);
  if (shown < 16) return nullptr;
  const auto& spectra = content.transfer.spectra;
  const VectorXd frequency = spectra.frequency_hz.segment(1, shown - 1);
  const double lowest = std::max(content.transfer.band.lo_hz, 4.0 * frequency[0]);
  // Bands as they are compared: half octaves from 20 Hz up and down.
  double lo = 20.0 * std::exp2(0.5 * std::ceil(2.0 * std::log2(lowest / 20.0)));
  while (lo * std::numbers::sqrt2 > content.highest_hz) lo /= std::numbers::sqrt2;  // a narrow band up there
  const VectorXd edge = ident::half_octave_edges(lo, content.highest_hz);
  const auto amplitude = [](const VectorXd& density) -> json {
    return density.size() == 0 ? json(nullptr) : numbers(density.cwiseSqrt(), 4);
  };
  json list = json::array();
  for (const auto& density : densities(content, frequency)) {
    list.push_back({{"name", density.name},
                    {"unit", density.unit},
                    {"density", amplitude(density.simulated)},
                    {"densityLinear", amplitude(density.linear)},
                    {"densityMeasured", amplitude(density.measured)},
                    {"levels", levels(frequency, density.simulated, edge)},
                    {"levelsLinear", levels(frequency, density.linear, edge)},
                    {"levelsMeasured", levels(frequency, density.measured, edge)}});
  }
  return {{"frequency", numbers(frequency)},
          {"resolution", number(spectra.resolution_hz)},
          {"edges", numbers(edge)},
          {"outputs", std::move(list)}};
}

json transfer_json(const SimulationReportContent& content) {
  const auto& transfer = content.transfer;
  if (transfer.function.lines() == 0) return nullptr;
  json entry = {{"simulated", transfer_function_json(transfer.function)}};
  if (transfer.amplitude_ratio.lines() > 0)
    entry["amplitudeRatio"] = transfer_function_json(transfer.amplitude_ratio);
  if (content.linear) entry["linear"] = transfer_function_json(*content.linear);
  if (content.measured && content.measured->transfer.function.lines() > 0)
    entry["measured"] = transfer_function_json(content.measured->transfer.function);
  return entry;
}

json energy_json(const fem::SimulationReport& report) {
  if (!report.energy) return nullptr;
  const auto& energy = *report.energy;
  return {{"initial", number(energy.initial)},
          {"input", number(energy.input)},
          {"kinetic", number(energy.kinetic)},
          {"strain", number(energy.strain)},
          {"contactStored", number(energy.contact_stored)},
          {"bodyDissipated", number(energy.body_dissipated)},
          {"contactDissipated", number(energy.contact_dissipated)},
          {"staticJumps", number(energy.static_jumps)},
          {"imbalance", number(energy.imbalance(), 3)}};
}

json comparison_json(const SimulationReportContent& content) {
  if (!content.measured) return nullptr;
  const auto& comparison = content.measured->comparison;
  json signals = json::array();
  for (const auto& signal : comparison.signals) {
    signals.push_back({{"name", signal.name},
                       {"unit", ident::si_unit(signal.quantity)},
                       {"correlation", numbers(signal.correlation, 6)},
                       {"all", number(signal.correlation_of_all, 6)},
                       {"edges", numbers(signal.measured.edge_hz)},
                       {"measured", numbers(signal.measured.rms, 5)},
                       {"simulated", numbers(signal.simulated.rms, 5)},
                       {"difference", numbers(signal.level_db, 5)}});
  }
  return {
      {"file", content.measured->file},         {"interval", number(comparison.interval)},
      {"skipped", number(comparison.skipped)},  {"signals", std::move(signals)},
      {"notCompared", comparison.not_compared}, {"motionCorrelation", number(comparison.motion_correlation)}};
}

json page_data(const SimulationReportContent& content) {
  const ident::Record shown = shown_record(content);
  return {{"title", content.title},
          {"command", content.command},
          {"version", content.provenance.program_version},
          {"date", content.provenance.date},
          {"inputs", text_pairs(content.provenance.inputs)},
          {"inputFiles", text_pairs(content.input_files)},
          {"warnings", content.report.warnings},
          {"chosen", text_pairs(content.chosen)},
          {"linear", content.report.linear},
          {"complete", content.report.complete},
          {"events", content.report.steps.events},
          {"deepest", number(content.report.steps.largest_penetration)},
          {"nearest", number(content.report.largest_offset)},
          {"band", {number(content.transfer.band.lo_hz), number(content.transfer.band.hi_hz)}},
          {"atRest", content.transfer.at_rest},
          {"duration", number(static_cast<double>(shown.samples.rows()) * shown.sample_interval)},
          {"sampleRate", number(1.0 / shown.sample_interval)},
          {"whole", envelope(shown)},
          {"excerpt", excerpt(content, shown)},
          {"contacts", contact_maps(content)},
          {"spectra", spectra_json(content)},
          {"transfer", transfer_json(content)},
          {"energy", energy_json(content.report)},
          {"comparison", comparison_json(content)}};
}

}  // namespace

std::string render_simulation_report(const SimulationReportContent& content) {
  static const std::vector<PageSection> sections = {{"summary", "Result"},
                                                    {"measured", "Simulated against measured"},
                                                    {"waveforms", "Motion and outputs over time"},
                                                    {"contact", "Contact over time and length"},
                                                    {"transfer", "Transfer functions"},
                                                    {"spectra", "Spectra"},
                                                    {"energy", "Energy"},
                                                    {"provenance", "Settings, inputs, how to reproduce"}};
  return render_page(content.title, sections, page_data(content), simulate_report_js);
}

}  // namespace struna::apps
