#include "apps/limit_page.hpp"

#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/limit_files.hpp"
#include "apps/limit_svg.hpp"
#include "apps/report_page.hpp"

namespace struna::apps {
namespace {

using nlohmann::json;

json summary_row(const LimitMap& map) {
  const LimitCount count = count_of(map);
  return {{"name", map.name},
          {"title", map.title},
          {"right", count.right},
          {"alarms", count.false_alarm_text()},
          {"uncertain", count.uncertain},
          {"wrong", count.wrong},
          {"flagged", count.flagged_text()},
          {"refused", count.refused}};
}

/// How often each combination of flags came with right, uncertain and wrong results.
json flag_rows(const LimitMap& map) {
  std::map<std::string, std::array<long, 3>> counts;
  for (const auto& trial : map.trials) {
    const Outcome result = outcome(trial);
    auto& entry = counts[trial.flags];
    entry[0] += result == Outcome::right;
    entry[1] += result == Outcome::uncertain;
    entry[2] += result == Outcome::wrong;
  }
  json rows = json::array();
  for (const auto& [flags, count] : counts)
    if (count[0] + count[1] + count[2] > 0) rows.push_back({flags, count[0], count[1], count[2]});
  return rows;
}

}  // namespace

std::string limit_page(const std::vector<LimitMap>& maps, const std::string& command) {
  std::vector<PageSection> sections = {{"summary", "Summary"}};
  json data = {{"command", command}, {"summary", json::array()}, {"maps", json::array()}};
  for (const auto& map : maps) {
    sections.push_back({map.name, map.title});
    data["summary"].push_back(summary_row(map));
    data["maps"].push_back({{"name", map.name},
                            {"sentence", sentence_of(map)},
                            {"quantity", map.quantity},
                            {"svg", limit_svg(map)},
                            {"flags", flag_rows(map)}});
  }
  return render_page("Where methods stop working", sections, data, limit_page_js);
}

}  // namespace struna::apps
