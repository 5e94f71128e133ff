#pragma once

#include <string>
#include <vector>

#include "apps/tradeoff_chart.hpp"

namespace struna::apps {

/// A stage's charts.
struct TradeoffStage {
  std::string name;     ///< "modes"
  std::string heading;  ///< "Modes: method, noise, lines per bandwidth"
  std::vector<TradeoffChart> charts;
};

/// index.html, self-contained. `command` is how to make it again.
std::string tradeoff_page(const std::vector<TradeoffStage>& stages, const std::string& command);

}  // namespace struna::apps
