#include "apps/tradeoff_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/svg.hpp"

namespace struna::apps {
namespace {

// Okabe & Ito's colours, told apart with colour-blind eyes; the markers' shapes tell the same.
constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#aa4499",
                                   "#7a6a00", "#56b4e9", "#1a1d21", "#8a929b"};
constexpr int colour_count = 8;
constexpr double panel_width = 560.0;
constexpr double plot_height = 300.0;
constexpr double left = 62.0, right = 16.0, top = 40.0;
constexpr double legend_line = 17.0, text_line = 15.0;
/// Characters of the 12 px text that fit beside the axis: DejaVu Sans, the widest of the fonts, takes 0.62 of
/// its size per character of running text.
constexpr auto text_width = static_cast<std::size_t>((panel_width - left - right) / (0.62 * 12.0));

/// A logarithmic axis between two places on the picture.
struct LogAxis {
  double lo = 1.0, hi = 10.0;
  double from = 0.0, to = 1.0;
  double at(double value) const { return from + (to - from) * std::log(value / lo) / std::log(hi / lo); }
};

LogAxis axis_over(double lo, double hi, double from, double to) {
  const double room = std::max(0.08 * std::log10(hi / lo), 0.15);
  return {lo * std::pow(10.0, -room), hi * std::pow(10.0, room), from, to};
}

std::string power_of_ten(int exponent) {
  return exponent >= -2 && exponent <= 2 ? fmt::format("{:g}", std::pow(10.0, exponent))
                                         : fmt::format("1e{}", exponent);
}

/// Grid and numbers at the decades, thin lines at 2 and 5 where few decades are shown.
std::string grid(const LogAxis& axis, bool horizontal, double cross_from, double cross_to) {
  std::string text;
  const bool few = std::log10(axis.hi / axis.lo) < 3.0;
  for (int e = static_cast<int>(std::floor(std::log10(axis.lo))); e <= std::log10(axis.hi); ++e) {
    for (const int m : {1, 2, 5}) {
      const double value = m * std::pow(10.0, e);
      if (value < axis.lo || value > axis.hi || (m > 1 && !few)) continue;
      const double p = axis.at(value);
      const char* const stroke = m == 1 ? "#d5d9de" : "#edeff1";
      const std::string label = m == 1 ? power_of_ten(e) : fmt::format("{:g}", value);
      if (horizontal) {
        text += fmt::format("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"{3}\"/>\n", p, cross_from,
                            cross_to, stroke);
        text += text_at(p, cross_to + 14.0, "middle", label, "class=\"soft\"");
      } else {
        text += fmt::format("<path d=\"M{1:.1f} {0:.1f}H{2:.1f}\" stroke=\"{3}\"/>\n", p, cross_from,
                            cross_to, stroke);
        text += text_at(cross_from - 5.0, p + 4.0, "end", label, "class=\"soft\"");
      }
    }
  }
  return text;
}

std::string marker(int shape, double x, double y, const std::string& colour) {
  switch (shape % 4) {
    case 0:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.6\" fill=\"{}\"/>\n", x, y, colour);
    case 1:
      return fmt::format("<path d=\"M{:.1f} {:.1f}h7v7h-7z\" fill=\"{}\"/>\n", x - 3.5, y - 3.5, colour);
    case 2:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l4.4 7.6h-8.8z\" fill=\"{}\"/>\n", x, y - 4.8, colour);
    default:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l4.6 4.6-4.6 4.6-4.6-4.6z\" fill=\"{}\"/>\n", x, y - 4.6,
                         colour);
  }
}

/// One chart's points, by method in the order of the rows.
struct Panel {
  const TradeoffChart& chart;
  std::vector<std::string> methods;
  std::vector<std::vector<TradeoffRow>> rows;
  LogAxis x, y;
};

double drawn_error(const TradeoffChart& chart, const TradeoffRow& row) {
  return std::max(told_error(chart, row), 1e-16);
}

Panel panel_of(const TradeoffChart& chart) {
  Panel panel{chart, {}, {}, {}, {}};
  double x_lo = std::numeric_limits<double>::infinity(), x_hi = 0.0;
  double y_lo = x_lo, y_hi = 0.0;
  for (const auto& row : chart.rows) {
    if (!std::isfinite(row.error) || !(row.seconds > 0.0)) continue;
    const auto found = std::find(panel.methods.begin(), panel.methods.end(), row.method);
    const auto index = static_cast<std::size_t>(found - panel.methods.begin());
    if (found == panel.methods.end()) {
      panel.methods.push_back(row.method);
      panel.rows.emplace_back();
    }
    panel.rows[index].push_back(row);
    x_lo = std::min(x_lo, row.seconds);
    x_hi = std::max(x_hi, row.seconds);
    y_lo = std::min(y_lo, drawn_error(chart, row));
    y_hi = std::max(y_hi, drawn_error(chart, row));
  }
  if (panel.methods.empty()) x_lo = y_lo = x_hi = y_hi = 1.0;
  panel.x = axis_over(x_lo, x_hi, left, panel_width - right);
  panel.y = axis_over(y_lo, y_hi, top + plot_height, top);
  return panel;
}

/// The front as a staircase: what can be had by a given time.
std::string front(const Panel& panel) {
  std::vector<TradeoffRow> rows;
  for (const auto& row : panel.chart.rows) {
    if (row.pareto) rows.push_back(row);
  }
  if (rows.empty()) return "";
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  std::string path;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double x = panel.x.at(rows[i].seconds);
    const double y = panel.y.at(drawn_error(panel.chart, rows[i]));
    path += i == 0 ? fmt::format("M{:.1f} {:.1f}", x, y) : fmt::format("H{:.1f}V{:.1f}", x, y);
  }
  return fmt::format("<path d=\"{}H{:.1f}\" fill=\"none\" stroke=\"#5b636d\" stroke-dasharray=\"5 4\"/>\n",
                     path, panel.x.to);
}

struct Box {
  double x0, y0, x1, y1;
  bool meets(const Box& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
};

/// The knob's value beside a point, where there is room for it.
std::string point_label(double x, double y, const std::string& text, std::vector<Box>& taken) {
  const double width = 5.6 * static_cast<double>(text.size());
  for (const auto& [dx, dy] :
       {std::pair{7.0, -5.0}, {7.0, 12.0}, {-width - 7.0, -5.0}, {-width - 7.0, 12.0}}) {
    const Box box{x + dx, y + dy - 9.0, x + dx + width, y + dy + 2.0};
    const bool inside = box.x0 > left && box.x1 < panel_width && box.y0 > top - 4.0;
    const bool free = std::none_of(taken.begin(), taken.end(), [&](const Box& o) { return box.meets(o); });
    if (!inside || !free) continue;
    taken.push_back(box);
    return text_at(x + dx, y + dy, "start", text, "class=\"small\"");
  }
  return "";
}

std::string points(const Panel& panel) {
  std::string lines, marks, labels;
  std::vector<Box> taken;
  for (const auto& rows : panel.rows) {
    for (const auto& row : rows) {
      const double x = panel.x.at(row.seconds), y = panel.y.at(drawn_error(panel.chart, row));
      taken.push_back({x - 4.0, y - 4.0, x + 4.0, y + 4.0});
    }
  }
  for (std::size_t m = 0; m < panel.rows.size(); ++m) {
    const std::string colour = colours[m % colour_count];
    std::string path;
    for (const auto& row : panel.rows[m]) {
      const double x = panel.x.at(row.seconds), y = panel.y.at(drawn_error(panel.chart, row));
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
      marks += marker(static_cast<int>(m), x, y, colour);
      if (row.is_default) {
        marks += fmt::format(
            "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"8\" fill=\"none\" stroke=\"#1a1d21\" "
            "stroke-width=\"1.6\"/>\n",
            x, y);
      }
      labels += point_label(x, y, fmt::format("{:.3g}", row.value), taken);
    }
    lines += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\"/>\n", path, colour);
  }
  return lines + marks + labels;
}

std::string reference_line(const Panel& panel) {
  const double error = panel.chart.reference_error;
  if (!(error > panel.y.lo && error < panel.y.hi)) return "";
  const double y = panel.y.at(error);
  return fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"#d55e00\" stroke-dasharray=\"2 3\"/>\n",
                     left, y, panel.x.to) +
         text_at(panel.x.to, y - 4.0, "end", "error of the reference", "class=\"small soft\"");
}

/// What stands below a plot: the methods with their knobs, and the advice.
std::string below(const Panel& panel, double& y) {
  std::string text;
  for (std::size_t m = 0; m < panel.methods.size(); ++m) {
    text += marker(static_cast<int>(m), left + 6.0, y - 4.0, colours[m % colour_count]);
    text += text_at(left + 18.0, y, "start",
                    fmt::format("{} (label: {})", panel.methods[m], panel.rows[m].front().knob));
    y += legend_line;
  }
  text += text_at(left, y, "start", "ring: the default; dashed: the Pareto front", "class=\"soft\"");
  y += legend_line + 2.0;
  for (const auto& line : wrapped(advice(panel.chart), text_width)) {
    text += text_at(left, y, "start", line);
    y += text_line;
  }
  return text;
}

std::string panel_svg(const TradeoffChart& chart, double& height) {
  const Panel panel = panel_of(chart);
  const double bottom = top + plot_height;
  std::string text = text_at(left, 20.0, "start", chart_title(chart), "class=\"title\"");
  text += grid(panel.x, true, top, bottom) + grid(panel.y, false, left, panel_width - right);
  text +=
      fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#5b636d\"/>\n",
                  left, top, panel_width - right - left, plot_height);
  text += reference_line(panel) + front(panel) + points(panel);
  text += text_at(0.5 * (left + panel_width - right), bottom + 30.0, "middle", "time, one thread [s]");
  text += text_at(0.0, 0.0, "middle", "error of the " + chart.quantity + " [-]",
                  fmt::format("transform=\"translate(14 {:.1f}) rotate(-90)\"", top + 0.5 * plot_height));
  height = bottom + 52.0;
  text += below(panel, height);
  return text;
}

}  // namespace

std::string tradeoff_svg(const std::vector<TradeoffChart>& charts) {
  std::string body;
  double y = 8.0;
  for (std::size_t i = 0; i < charts.size(); i += 2) {
    double row_height = 0.0;
    for (std::size_t k = i; k < std::min(i + 2, charts.size()); ++k) {
      double height = 0.0;
      const std::string panel = panel_svg(charts[k], height);
      body += fmt::format("<g transform=\"translate({:.0f} {:.0f})\">\n{}</g>\n",
                          static_cast<double>(k - i) * (panel_width + 20.0), y, panel);
      row_height = std::max(row_height, height);
    }
    y += row_height + 14.0;
  }
  const double width = (charts.size() > 1 ? 2.0 * panel_width + 20.0 : panel_width) + 10.0;
  return svg_picture(width, y, body);
}

}  // namespace struna::apps
