#include "apps/tradeoff_page.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/report_page.hpp"
#include "apps/tradeoff_files.hpp"

namespace struna::apps {
namespace {

using nlohmann::json;

json row_json(const TradeoffChart& chart, const TradeoffRow& row) {
  return {{"method", row.method},
          {"knob", row.knob},
          {"label", row_label(row)},
          {"value", number(row.value, 4)},
          {"error", number(row.error, 4)},
          {"told", number(std::max(told_error(chart, row), 1e-16), 4)},
          {"seconds", number(row.seconds, 4)},
          {"pareto", row.pareto},
          {"isDefault", row.is_default}};
}

json chart_json(const TradeoffChart& chart) {
  json rows = json::array();
  for (const auto& row : chart.rows) rows.push_back(row_json(chart, row));
  json better = json::array();
  for (const auto& row : better_than_default(chart)) better.push_back(row.method + ", " + row_label(row));
  return {{"title", chart_title(chart)},
          {"quantity", chart.quantity},
          {"errorLabel", chart.error_label},
          {"reference", chart.reference},
          {"referenceError", number(chart.reference_error, 3)},
          {"advice", advice(chart)},
          {"notes", chart.notes},
          {"better", std::move(better)},
          {"rows", std::move(rows)}};
}

}  // namespace

std::string tradeoff_page(const std::vector<TradeoffStage>& stages, const std::string& command) {
  std::vector<PageSection> sections;
  json data = {{"command", command}, {"stages", json::array()}};
  for (const auto& stage : stages) {
    sections.push_back({stage.name, stage.heading});
    json charts = json::array();
    for (const auto& chart : stage.charts) charts.push_back(chart_json(chart));
    data["stages"].push_back({{"name", stage.name}, {"charts", std::move(charts)}});
  }
  return render_page("Error against time", sections, data, tradeoff_page_js);
}

}  // namespace struna::apps
