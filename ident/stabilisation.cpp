#include "ident/stabilisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fem/error.hpp"
#include "ident/common_denominator.hpp"
#include "ident/line_blocks.hpp"
#include "ident/modal_assurance.hpp"
#include "ident/schwarz_penalty.hpp"

namespace struna::ident {
namespace {

constexpr double least_lines = 64.0, most_lines = 4000.0;  // of a window
constexpr double window_width = 0.6;                       // of its upper end
constexpr double overlap = 0.4;                            // of two windows, of the width
constexpr long lines_per_order = 4, fewest_lines = 2 * lines_per_order;
constexpr double zoom_bandwidths = 6.0;  // either side of a column; enough beside a trend
constexpr double least_zoom_lines = 48.0;
constexpr double zoom_territory = 3.0;  // bandwidths either side that the zoom tells
constexpr double zoom_together = 2.0;   // bandwidths: nearer columns are looked at together
constexpr double worth_zooming = 0.7;   // of the window's width: a wider zoom shows nothing new
constexpr double narrowest = 0.3;       // half-power band in line spacings, as the multi-mode fit asks for
constexpr double same_frequency = 0.25, same_loss_factor = 1.0 / 3.0;  // parts of the pole's own

void check(const TransferFunction& tf, const StabilisationOptions& options) {
  if (tf.lines() < 5) throw Error(fmt::format("stabilise: at least 5 lines, got {}", tf.lines()));
  if (options.max_order < 4 || options.max_order > 60)
    throw Error(fmt::format("stabilise: max_order 4 to 60, got {}", options.max_order));
  if (options.least_orders < 2 || options.least_orders > options.max_order)
    throw Error(fmt::format("stabilise: least_orders 2 to max_order {}, got {}", options.max_order,
                            options.least_orders));
  const std::pair<const char*, double> tolerances[] = {
      {"frequency_tolerance", options.frequency_tolerance},
      {"loss_factor_tolerance", options.loss_factor_tolerance},
      {"shape_tolerance", options.shape_tolerance}};
  for (const auto& [name, value] : tolerances)
    if (!(value > 0.0 && value <= 0.5))
      throw Error(fmt::format("stabilise: {} above 0 and up to 0.5, got {}", name, value));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double spread(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), static_cast<long>(values.size()));
  return std::sqrt((all - all.mean()).square().sum() / std::max(1.0, static_cast<double>(all.size()) - 1.0));
}

// ---- lines of a window ----

// Weighted means of neighbouring lines where there are too many.
TransferFunction lines_within(const TransferFunction& tf, const Span& span) {
  const TransferFunction cut = restrict_band(tf, span.lo_hz, span.hi_hz);
  const auto each = static_cast<long>(std::ceil(static_cast<double>(cut.lines()) / most_lines));
  if (each == 1) return cut;
  std::vector<long> starts;
  for (long start = 0; start <= cut.lines(); start += each) starts.push_back(start);
  return in_blocks(cut, starts);
}

// From the top down, each from 0.4 of its upper end on or least_lines wide, overlapping by two fifths; the
// territories meet in the middle of the overlap.
std::vector<StabilisationWindow> wide_windows(const LineBand& band) {
  std::vector<StabilisationWindow> windows;
  double hi = band.hi_hz;
  while (true) {
    const double width = std::max(window_width * hi, least_lines * band.spacing_hz);
    // What would be left below is too narrow for a window of its own.
    const bool last = hi - width < band.lo_hz + 0.5 * least_lines * band.spacing_hz;
    const double lo = last ? band.lo_hz : hi - width;
    windows.push_back({{lo, hi}, {lo, hi}, 0});
    if (last) break;
    hi = lo + overlap * width;
  }
  std::reverse(windows.begin(), windows.end());
  for (std::size_t w = 1; w < windows.size(); ++w) {
    const double meet = 0.5 * (windows[w].lines.lo_hz + windows[w - 1].lines.hi_hz);
    windows[w].territory.lo_hz = windows[w - 1].territory.hi_hz = meet;
  }
  return windows;
}

// ---- poles from order to order ----

// Constants over the outputs' noise, so that none counts for its unit.
Eigen::VectorXd shape_weights(const TransferFunction& tf) {
  Eigen::VectorXd weight(static_cast<long>(tf.outputs.size()));
  for (long k = 0; k < weight.size(); ++k)
    weight(k) = 1.0 / tf.outputs[static_cast<std::size_t>(k)].sigma.mean();
  return weight;
}

struct Change {
  double frequency;    // in bandwidths
  double loss_factor;  // relative
};
Change change_of(const Pole& from, const Pole& to) {
  return {std::abs(to.natural_frequency_hz - from.natural_frequency_hz) /
              std::min(bandwidth_hz(from), bandwidth_hz(to)),
          std::abs(to.loss_factor - from.loss_factor) / std::min(from.loss_factor, to.loss_factor)};
}

// Pairs of poles of two orders, the nearest first, each pole once: index below of each above, or -1.
std::vector<long> linked(const std::vector<OrderPole>& below, const std::vector<OrderPole>& above) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < above.size(); ++i)
    for (std::size_t j = 0; j < below.size(); ++j) {
      const Change change = change_of(below[j].pole, above[i].pole);
      if (change.frequency < 1.0) pairs.emplace_back(std::hypot(change.frequency, change.loss_factor), i, j);
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<long> partner(above.size(), -1);
  std::vector<bool> taken(below.size(), false);
  for (const auto& [distance, i, j] : pairs) {
    if (partner[i] >= 0 || taken[j]) continue;
    partner[i] = static_cast<long>(j);
    taken[j] = true;
  }
  return partner;
}

Stability stability_of(const OrderPole& below, const OrderPole& above, const Eigen::VectorXd& weight,
                       const StabilisationOptions& options) {
  const Change change = change_of(below.pole, above.pole);
  if (change.frequency > options.frequency_tolerance) return Stability::fresh;
  if (change.loss_factor > options.loss_factor_tolerance) return Stability::frequency;
  const bool same_shape = 1.0 - modal_assurance(weight.asDiagonal() * below.modal_constant,
                                                weight.asDiagonal() * above.modal_constant) <=
                          options.shape_tolerance;
  return same_shape ? Stability::all : Stability::damping;
}

// Poles of all orders with their stability; `column` numbers the chains.
std::vector<OrderPole> chained(const std::vector<std::vector<DenominatorPole>>& orders,
                               const TransferFunction& lines, const StabilisationOptions& options) {
  const auto outputs = static_cast<double>(lines.outputs.size());
  const double least_gain =
      schwarz_penalty({2.0 + 2.0 * outputs, 2.0 * outputs * static_cast<double>(lines.lines())});
  const double least_bandwidth = narrowest * band_of(lines).spacing_hz;
  const Eigen::VectorXd weight = shape_weights(lines);
  std::vector<OrderPole> all, below;
  int chains = 0;
  for (std::size_t n = 0; n < orders.size(); ++n) {
    std::vector<OrderPole> above;
    for (const DenominatorPole& found : orders[n])
      if (found.gain > least_gain && bandwidth_hz(found.pole) > least_bandwidth)
        above.push_back({static_cast<int>(n) + 1, found.pole, found.modal_constant, Stability::fresh, -1});
    const std::vector<long> partner = linked(below, above);
    for (std::size_t i = 0; i < above.size(); ++i) {
      if (partner[i] < 0) continue;
      OrderPole& from = below[static_cast<std::size_t>(partner[i])];
      above[i].stability = stability_of(from, above[i], weight, options);
      if (above[i].stability != Stability::all) continue;
      if (from.column < 0) from.column = chains++;
      above[i].column = from.column;
    }
    all.insert(all.end(), below.begin(), below.end());
    below = std::move(above);
  }
  all.insert(all.end(), below.begin(), below.end());
  return all;
}

// ---- chains to columns ----

StableColumn column_of(const std::vector<const OrderPole*>& members) {
  std::vector<double> f, eta;
  for (const OrderPole* member : members) {
    f.push_back(member->pole.natural_frequency_hz);
    eta.push_back(member->pole.loss_factor);
  }
  StableColumn column;
  column.pole = {median(f), median(eta)};
  column.frequency_spread_hz = spread(f);
  column.loss_factor_spread = spread(eta);
  column.orders = static_cast<int>(members.size());
  column.modal_constant = members.back()->modal_constant;
  return column;
}

bool near(const Pole& a, const Pole& b) {
  const Change change = change_of(a, b);
  return change.frequency < same_frequency && change.loss_factor < same_loss_factor;
}

bool share_an_order(const std::vector<const OrderPole*>& a, const std::vector<const OrderPole*>& b) {
  return std::any_of(a.begin(), a.end(), [&](const OrderPole* pole) {
    return std::any_of(b.begin(), b.end(),
                       [&](const OrderPole* other) { return other->order == pole->order; });
  });
}

struct Found {
  StabilisationWindow window;
  std::vector<OrderPole> poles;
  std::vector<StableColumn> columns;
};

// Long chains are columns; shorter ones, and such as go on where another has broken off, join them.
void gather_columns(std::vector<OrderPole>& poles, int least_orders, Found& found) {
  int chains = 0;
  for (const OrderPole& pole : poles) chains = std::max(chains, pole.column + 1);
  std::vector<std::vector<const OrderPole*>> members(static_cast<std::size_t>(chains));
  for (const OrderPole& pole : poles)
    if (pole.column >= 0) members[static_cast<std::size_t>(pole.column)].push_back(&pole);
  std::vector<std::size_t> by_length(members.size());
  for (std::size_t c = 0; c < by_length.size(); ++c) by_length[c] = c;
  std::stable_sort(by_length.begin(), by_length.end(),
                   [&](std::size_t a, std::size_t b) { return members[a].size() > members[b].size(); });
  std::vector<int> column_of_chain(members.size(), -1);
  std::vector<std::size_t> chain_of_column;
  for (const std::size_t c : by_length) {
    const Pole pole = column_of(members[c]).pole;
    const auto home = std::find_if(chain_of_column.begin(), chain_of_column.end(), [&](std::size_t other) {
      return near(column_of(members[other]).pole, pole) && !share_an_order(members[other], members[c]);
    });
    if (home != chain_of_column.end()) {
      members[*home].insert(members[*home].end(), members[c].begin(), members[c].end());
      column_of_chain[c] = column_of_chain[*home];
    } else if (static_cast<int>(members[c].size()) >= least_orders) {
      column_of_chain[c] = static_cast<int>(chain_of_column.size());
      chain_of_column.push_back(c);
    }
  }
  for (const std::size_t chain : chain_of_column) {
    found.columns.push_back(column_of(members[chain]));
    found.columns.back().of_orders = found.window.max_order;
  }
  for (OrderPole& pole : poles)
    if (pole.column >= 0) pole.column = column_of_chain[static_cast<std::size_t>(pole.column)];
}

// ---- windows ----

long lines_in(const TransferFunction& tf, const Span& span) {
  return std::count_if(tf.frequency_hz.begin(), tf.frequency_hz.end(),
                       [&](double f) { return span.holds(f); });
}

// Nothing where lines are missing (those that an excitation did not reach): no order is analysed there.
Found analysed(const TransferFunction& tf, StabilisationWindow window, const StabilisationOptions& options) {
  if (lines_in(tf, window.lines) < fewest_lines) return {window, {}, {}};
  const TransferFunction lines = lines_within(tf, window.lines);
  window.max_order =
      static_cast<int>(std::min<long>(options.max_order, std::max(1L, lines.lines() / lines_per_order)));
  Found found{window, {}, {}};
  found.poles = chained(fit_common_denominator(lines, options.damping, window.max_order), lines, options);
  gather_columns(found.poles, options.least_orders, found);
  return found;
}

// Poles of the highest order there, stable or not.
long poles_in(const Found& found, const Span& span) {
  return std::count_if(found.poles.begin(), found.poles.end(), [&](const OrderPole& pole) {
    return pole.order == found.window.max_order && span.holds(pole.pole.natural_frequency_hz);
  });
}

// In two where the order does not suffice for all poles; each half sees half its width beyond its territory.
void survey(const TransferFunction& tf, const LineBand& band, const StabilisationWindow& window,
            const StabilisationOptions& options, std::vector<Found>& all) {
  Found found = analysed(tf, window, options);
  const Span& territory = window.territory;
  const double half = 0.5 * (territory.hi_hz - territory.lo_hz);
  if (3 * poles_in(found, territory) <= found.window.max_order ||
      half < 0.5 * least_lines * band.spacing_hz) {
    all.push_back(std::move(found));
    return;
  }
  for (const double lo : {territory.lo_hz, territory.lo_hz + half}) {
    const Span part{lo, lo + half};
    const Span lines{std::max(band.lo_hz, part.lo_hz - 0.5 * half),
                     std::min(band.hi_hz, part.hi_hz + 0.5 * half)};
    survey(tf, band, {lines, part, 0}, options, all);
  }
}

// A window around columns [first, last).
StabilisationWindow zoom_on(const std::vector<StableColumn>& columns, std::size_t first, std::size_t last,
                            const LineBand& band) {
  StabilisationWindow zoom;
  zoom.lines = {band.hi_hz, band.lo_hz};
  zoom.territory = zoom.lines;
  const auto stretch = [&](Span& span, double f, double reach) {
    span.lo_hz = std::max(band.lo_hz, std::min(span.lo_hz, f - reach));
    span.hi_hz = std::min(band.hi_hz, std::max(span.hi_hz, f + reach));
  };
  for (std::size_t c = first; c < last; ++c) {
    const double f = columns[c].pole.natural_frequency_hz, bandwidth = bandwidth_hz(columns[c].pole);
    stretch(zoom.lines, f, std::max(zoom_bandwidths * bandwidth, 0.5 * least_zoom_lines * band.spacing_hz));
    stretch(zoom.territory, f, zoom_territory * bandwidth);
  }
  return zoom;
}

std::vector<StabilisationWindow> zooms_of(const std::vector<StableColumn>& columns, const LineBand& band) {
  std::vector<StabilisationWindow> zooms;
  std::size_t first = 0;
  for (std::size_t c = 1; c <= columns.size(); ++c) {
    if (c < columns.size()) {
      const double apart = columns[c].pole.natural_frequency_hz - columns[c - 1].pole.natural_frequency_hz;
      if (apart < zoom_together * std::max(bandwidth_hz(columns[c].pole), bandwidth_hz(columns[c - 1].pole)))
        continue;
    }
    zooms.push_back(zoom_on(columns, first, c, band));
    const std::size_t z = zooms.size() - 1;
    if (z > 0 && zooms[z].territory.lo_hz < zooms[z - 1].territory.hi_hz) {
      const double meet =
          0.5 * (columns[first].pole.natural_frequency_hz + columns[first - 1].pole.natural_frequency_hz);
      zooms[z].territory.lo_hz = zooms[z - 1].territory.hi_hz = meet;
    }
    first = c;
  }
  return zooms;
}

// ---- all together ----

// What a window tells of one piece of the band.
void tell(const Found& found, const Span& piece, Stabilisation& all) {
  if (!(piece.hi_hz > piece.lo_hz)) return;
  StabilisationWindow window = found.window;
  window.territory = piece;
  all.windows.push_back(window);
  const auto here = [&](const Pole& pole) {
    return pole.natural_frequency_hz >= piece.lo_hz && pole.natural_frequency_hz < piece.hi_hz;
  };
  std::vector<int> number(found.columns.size(), -1);
  for (std::size_t c = 0; c < found.columns.size(); ++c) {
    if (!here(found.columns[c].pole)) continue;
    number[c] = static_cast<int>(all.columns.size());
    all.columns.push_back(found.columns[c]);
  }
  for (const OrderPole& pole : found.poles) {
    // A column's members go with it, wherever in the neighbourhood they are.
    const bool in_column = pole.column >= 0 && number[static_cast<std::size_t>(pole.column)] >= 0;
    if (pole.column >= 0 ? !in_column : !here(pole.pole)) continue;
    all.poles.push_back(pole);
    all.poles.back().column = in_column ? number[static_cast<std::size_t>(pole.column)] : -1;
  }
}

void sort_by_frequency(Stabilisation& all) {
  std::sort(all.windows.begin(), all.windows.end(),
            [](const auto& a, const auto& b) { return a.territory.lo_hz < b.territory.lo_hz; });
  std::vector<std::size_t> rank(all.columns.size()), place(all.columns.size());
  for (std::size_t c = 0; c < rank.size(); ++c) rank[c] = c;
  std::sort(rank.begin(), rank.end(), [&](std::size_t a, std::size_t b) {
    return all.columns[a].pole.natural_frequency_hz < all.columns[b].pole.natural_frequency_hz;
  });
  std::vector<StableColumn> columns;
  for (std::size_t r = 0; r < rank.size(); ++r) {
    columns.push_back(std::move(all.columns[rank[r]]));
    place[rank[r]] = r;
  }
  all.columns = std::move(columns);
  for (OrderPole& pole : all.poles)
    if (pole.column >= 0) pole.column = static_cast<int>(place[static_cast<std::size_t>(pole.column)]);
  std::stable_sort(all.poles.begin(), all.poles.end(), [](const OrderPole& a, const OrderPole& b) {
    return a.pole.natural_frequency_hz < b.pole.natural_frequency_hz;
  });
}

// The wide windows' territories less the zooms'.
Stabilisation combined(const std::vector<Found>& wide, const std::vector<Found>& zooms) {
  Stabilisation all;
  for (const Found& found : zooms) tell(found, found.window.territory, all);
  for (const Found& found : wide) {
    double from = found.window.territory.lo_hz;
    const double to = found.window.territory.hi_hz;
    for (const Found& zoom : zooms) {
      const Span& taken = zoom.window.territory;
      if (taken.hi_hz <= from || taken.lo_hz >= to) continue;
      tell(found, {from, taken.lo_hz}, all);
      from = taken.hi_hz;
    }
    tell(found, {from, to}, all);
  }
  sort_by_frequency(all);
  return all;
}

}  // namespace

std::string to_string(Stability stability) {
  switch (stability) {
    case Stability::fresh:
      return "new";
    case Stability::frequency:
      return "f";
    case Stability::damping:
      return "f+eta";
    case Stability::all:
      return "all";
  }
  throw Error("to_string(Stability): not a stability");
}

Stabilisation stabilise(const TransferFunction& tf, const StabilisationOptions& options) {
  check(tf, options);
  const LineBand band = band_of(tf);
  std::vector<Found> wide;
  for (const StabilisationWindow& window : wide_windows(band)) survey(tf, band, window, options, wide);
  const Stabilisation first = combined(wide, {});
  std::vector<Found> zooms;
  for (const StabilisationWindow& zoom : zooms_of(first.columns, band)) {
    const double middle = 0.5 * (zoom.territory.lo_hz + zoom.territory.hi_hz);
    const auto seen =
        std::find_if(first.windows.begin(), first.windows.end(),
                     [&](const StabilisationWindow& window) { return window.territory.holds(middle); });
    if (seen != first.windows.end() &&
        zoom.lines.hi_hz - zoom.lines.lo_hz < worth_zooming * (seen->lines.hi_hz - seen->lines.lo_hz))
      zooms.push_back(analysed(tf, zoom, options));
  }
  return combined(wide, zooms);
}

OrderCount orders_of(const Stabilisation& stabilisation, const Pole& pole) {
  OrderCount count;
  for (const StabilisationWindow& window : stabilisation.windows)
    if (window.territory.holds(pole.natural_frequency_hz)) count.of = window.max_order;
  std::vector<bool> standing(static_cast<std::size_t>(count.of) + 1, false);
  for (const OrderPole& found : stabilisation.poles)
    if (found.order <= count.of && near(found.pole, pole))
      standing[static_cast<std::size_t>(found.order)] = true;
  count.standing = static_cast<int>(std::count(standing.begin(), standing.end(), true));
  return count;
}

}  // namespace struna::ident
