#include "apps/report_page.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>

#include "apps/report_files.hpp"

namespace struna::apps {
namespace {

using nlohmann::json;

std::string replaced(std::string_view text, const std::map<char, std::string_view>& replacements) {
  std::string result;
  result.reserve(text.size() + text.size() / 64);
  for (const char c : text) {
    const auto found = replacements.find(c);
    if (found == replacements.end())
      result += c;
    else
      result += found->second;
  }
  return result;
}

std::string html_text(std::string_view text) {
  return replaced(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}});
}

/// JSON for a <script> element: "<" occurs in strings only, and escaped it can neither end the element nor
/// open a comment. Text that is not UTF-8 (a file name, say) shows replacement characters instead of losing
/// the report.
std::string script_json(const json& data) {
  return replaced(data.dump(-1, ' ', false, json::error_handler_t::replace), {{'<', "\\u003c"}});
}

/// The template with every {{name}} replaced, in one pass: what is put in is not searched again.
std::string filled(std::string_view page, const std::map<std::string_view, std::string_view>& parts) {
  std::string result;
  for (size_t position = 0;;) {
    const size_t open = page.find("{{", position);
    result += page.substr(position, open - position);
    if (open == std::string_view::npos) return result;
    const size_t close = page.find("}}", open);
    result += parts.at(page.substr(open + 2, close - open - 2));
    position = close + 2;
  }
}

}  // namespace

json number(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, digits - 1);
  double rounded = value;
  std::from_chars(text.data(), end.ptr, rounded);
  return rounded;
}

json numbers(const Eigen::VectorXd& values, int digits) {
  json list = json::array();
  list.get_ref<json::array_t&>().reserve(static_cast<size_t>(values.size()));
  for (const double value : values) list.push_back(number(value, digits));
  return list;
}

json numbers_by_row(const Eigen::MatrixXd& values, int digits) {
  json rows = json::array();
  for (long i = 0; i < values.rows(); ++i) rows.push_back(numbers(values.row(i), digits));
  return rows;
}

json text_pairs(const std::vector<std::pair<std::string, std::string>>& pairs) {
  json list = json::array();
  for (const auto& [name, value] : pairs) list.push_back({name, value});
  return list;
}

json transfer_function_json(const ident::TransferFunction& tf) {
  json outputs = json::array();
  for (const auto& output : tf.outputs) {
    json entry = {{"name", output.name},
                  {"kind", to_string(output.kind)},
                  {"unit", output.unit},
                  {"re", numbers(output.value.real())},
                  {"im", numbers(output.value.imag())}};
    if (output.coherence.size() > 0) entry["coherence"] = numbers(output.coherence, 5);
    if (output.sigma.size() > 0) entry["sigma"] = numbers(output.sigma, 4);
    outputs.push_back(std::move(entry));
  }
  return {{"frequency", numbers(tf.frequency_hz)}, {"outputs", std::move(outputs)}};
}

std::string render_page(const std::string& title, const std::vector<PageSection>& sections, const json& data,
                        std::string_view script) {
  std::string places;
  for (const auto& section : sections) {
    places += "  <section id=\"" + section.id + "\"><h2>" + html_text(section.heading) + "</h2></section>\n";
  }
  const std::string text = script_json(data);
  const std::string shown_title = html_text(title);
  return filled(report_html, {{"title", shown_title},
                              {"css", report_css},
                              {"sections", places},
                              {"data", text},
                              {"chart_js", chart_js},
                              {"axes_js", report_axes_js},
                              {"plots_js", report_plots_js},
                              {"elements_js", report_elements_js},
                              {"bode_js", report_bode_js},
                              {"stabilisation_js", report_stabilisation_js},
                              {"frame_js", report_frame_js},
                              {"js", script}});
}

}  // namespace struna::apps
