#include "ident/bootstrap.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"

namespace struna::ident {
namespace {

constexpr std::size_t fewest_replicates = 10;
constexpr double allowed = 3.5;      // standard errors of a ratio
constexpr double least_found = 0.9;  // of the replicates
constexpr double own_bandwidths = 0.5;

struct Moments {
  double sum = 0.0, squares = 0.0;
  long count = 0;
  void add(double v) {
    sum += v;
    squares += v * v;
    ++count;
  }
  double deviation() const {
    if (count < 2) return std::numeric_limits<double>::quiet_NaN();
    const double n = static_cast<double>(count);
    return std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1.0));
  }
};

/// The mode nearest to this one, null where none lies within its half-power band.
const Mode* nearest(const ModeSet& set, const Mode& mode) {
  const Mode* best = nullptr;
  double distance = own_bandwidths * mode.loss_factor * mode.natural_frequency_hz;
  for (const Mode& other : set.modes) {
    const double d = std::abs(other.natural_frequency_hz - mode.natural_frequency_hz);
    if (d < distance) {
      distance = d;
      best = &other;
    }
  }
  return best;
}

}  // namespace

BootstrapScatter bootstrap_scatter(const ModeSet& nominal, const std::vector<ModeSet>& replicates,
                                   long blocks) {
  if (replicates.size() < fewest_replicates)
    throw Error(fmt::format("bootstrap: at least {} replicates are needed, got {}", fewest_replicates,
                            replicates.size()));
  BootstrapScatter result;
  result.replicates = static_cast<long>(replicates.size());
  const double n = static_cast<double>(replicates.size());
  result.ratio_sigma = std::sqrt(0.5 / (n - 1.0) + 0.5 / static_cast<double>(blocks));
  double frequency_squares = 0.0, loss_squares = 0.0;
  long pooled = 0;
  for (const Mode& mode : nominal.modes) {
    Moments f, eta;
    for (const ModeSet& set : replicates)
      if (const Mode* const own = nearest(set, mode)) {
        f.add(own->natural_frequency_hz - mode.natural_frequency_hz);
        eta.add(own->loss_factor - mode.loss_factor);
      }
    ModeScatter scatter{f.deviation(), eta.deviation(), f.count};
    scatter.frequency_ratio = scatter.natural_frequency_sd / mode.natural_frequency_sigma;
    scatter.loss_factor_ratio = scatter.loss_factor_sd / mode.loss_factor_sigma;
    const bool seldom = static_cast<double>(scatter.found) < least_found * n;
    for (const double ratio : {scatter.frequency_ratio, scatter.loss_factor_ratio})
      scatter.doubtful = scatter.doubtful || seldom || ratio > 1.0 + allowed * result.ratio_sigma;
    if (!seldom && std::isfinite(scatter.frequency_ratio) && std::isfinite(scatter.loss_factor_ratio)) {
      frequency_squares += scatter.frequency_ratio * scatter.frequency_ratio;
      loss_squares += scatter.loss_factor_ratio * scatter.loss_factor_ratio;
      ++pooled;
    }
    result.modes.push_back(scatter);
  }
  result.frequency_ratio = std::sqrt(frequency_squares / static_cast<double>(pooled));
  result.loss_factor_ratio = std::sqrt(loss_squares / static_cast<double>(pooled));
  return result;
}

void write_bootstrap(const ModeSet& nominal, const BootstrapScatter& scatter, const std::string& file) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "mode,natural_frequency [Hz],natural_frequency_sigma [Hz],natural_frequency_bootstrap [Hz],"
                 "natural_frequency_ratio [-],loss_factor [-],loss_factor_sigma [-],loss_factor_bootstrap "
                 "[-],loss_factor_ratio [-],found [-],doubtful\n");
  const auto field = [](double v) { return std::isfinite(v) ? fmt::format("{:.10g}", v) : std::string(); };
  for (std::size_t r = 0; r < nominal.modes.size(); ++r) {
    const Mode& mode = nominal.modes[r];
    const ModeScatter& own = scatter.modes[r];
    fmt::format_to(out, "{},{},{},{},{},{},{},{},{},{:.6g},{}\n", r + 1, field(mode.natural_frequency_hz),
                   field(mode.natural_frequency_sigma), field(own.natural_frequency_sd),
                   field(own.frequency_ratio), field(mode.loss_factor), field(mode.loss_factor_sigma),
                   field(own.loss_factor_sd), field(own.loss_factor_ratio),
                   static_cast<double>(own.found) / static_cast<double>(scatter.replicates),
                   own.doubtful ? "yes" : "");
  }
  write_atomically(file, std::string_view(text.data(), text.size()));
}

}  // namespace struna::ident
