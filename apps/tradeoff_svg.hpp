#pragma once

#include <string>
#include <vector>

#include "apps/tradeoff_chart.hpp"

namespace struna::apps {

/// The charts of a stage as one picture, two in a row: log error over log time, a line per method, points
/// labelled by the knob, the front dashed, the default ringed, the advice below. Rows without a finite error
/// or time are left out; errors below the reference's own lie on its line.
std::string tradeoff_svg(const std::vector<TradeoffChart>& charts);

}  // namespace struna::apps
