#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/line_band.hpp"
#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

struct StabilisationOptions {
  fem::Damping damping = fem::Damping::structural;
  int max_order = 14;  ///< 4 to 60; less in windows with fewer than four lines an order
  // How far a stable pole may move from one order to the next.
  double frequency_tolerance = 0.2;     ///< in bandwidths; above 0, up to 0.5
  double loss_factor_tolerance = 0.25;  ///< relative; above 0, up to 0.5
  double shape_tolerance = 0.05;        ///< 1 - assurance of the constants over outputs; above 0, up to 0.5
  int least_orders = 4;                 ///< in turn, of a stable column; 2 to max_order
};

/// What of a pole stays as in the order below: nothing (new); its frequency; loss factor too; shape over
/// outputs too.
enum class Stability { fresh, frequency, damping, all };
std::string to_string(Stability stability);  ///< "new", "f", "f+eta", "all"

struct OrderPole {
  int order = 0;
  Pole pole;
  Eigen::VectorXcd modal_constant;  ///< C per output, as in Mode; of the start's accuracy
  Stability stability = Stability::fresh;
  int column = -1;  ///< index into columns, -1: of none
};

/// A pole that stays over the orders.
struct StableColumn {
  Pole pole;                         ///< median over its orders
  double frequency_spread_hz = 0.0;  ///< standard deviation over its orders
  double loss_factor_spread = 0.0;
  int orders = 0;     ///< in which it stands
  int of_orders = 0;  ///< analysed there
  Eigen::VectorXcd modal_constant;
};

/// Lines that were analysed together, and the part of the band that is told from them.
struct StabilisationWindow {
  Span lines;
  Span territory;
  int max_order = 0;
};

struct Stabilisation {
  std::vector<StabilisationWindow> windows;  ///< territories ascending, without gap or overlap
  std::vector<OrderPole> poles;              ///< ascending in frequency
  std::vector<StableColumn> columns;         ///< ascending in frequency
};

/// Which poles stay when the order of the model rises? (Van der Auweraer et al., J. Dyn. Syst. Meas. Control
/// 123 (2001) 651; docs/stabilisation.md.) Windows from 0.4 of their upper end on cover the band,
/// overlapping; in each a common denominator of every order up to max_order is fitted
/// (common_denominator.hpp), each pole is linked to the nearest of the order below, and chains of
/// least_orders or more poles that stay in frequency, loss factor and shape make a column. A window whose
/// highest order has more than max_order/3 poles is cut in two. Around each column (those within two
/// bandwidths together) the analysis is repeated in a window of six bandwidths either side, where near poles
/// part. Poles whose share takes less out of the sum of squares than Schwarz's criterion asks of a further
/// pole are left out, as are those narrower than 0.3 line spacings (one line that stands out). Windows of
/// more than 4000 lines are averaged down to that. `tf` in circle form with sigma, at least 5 lines; Error
/// otherwise and for options out of range.
Stabilisation stabilise(const TransferFunction& tf, const StabilisationOptions& options = {});

/// Orders in which a pole stands within a quarter of the bandwidth and a third of the loss factor of this
/// one, and orders analysed there.
struct OrderCount {
  int standing = 0;
  int of = 0;
};
OrderCount orders_of(const Stabilisation& stabilisation, const Pole& pole);

}  // namespace struna::ident
