#include "apps/limit_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/svg.hpp"

namespace struna::apps {
namespace {

constexpr double left = 66.0, top = 58.0, gap = 18.0;
constexpr double cell_width = 34.0, cell_height = 24.0;
constexpr std::size_t panels_in_row = 2;

struct Share {
  const char* label;
  const char* colour;
};
/// Okabe & Ito's colours; the wrong without a flag are the darkest.
constexpr std::array<Share, 6> shares = {{{"right", "#8fd0ba"},
                                          {"right, flagged", "#f0e442"},
                                          {"uncertain", "#56b4e9"},
                                          {"wrong, flagged", "#e69f00"},
                                          {"wrong, no flag", "#9c1f1f"},
                                          {"refused", "#c3c9d0"}}};

std::array<long, 6> split(const LimitCount& count) {
  return {count.right - count.right_flagged, count.right_flagged, count.uncertain, count.wrong_flagged,
          count.wrong - count.wrong_flagged, count.refused};
}

std::string cell(const LimitCount& count, double x, double y) {
  const auto parts = split(count);
  double total = 0.0;
  for (const long part : parts) total += static_cast<double>(part);
  if (total == 0.0) return "";
  std::string tip, boxes;
  double from = x;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k] == 0) continue;
    const double width = (cell_width - 1.0) * static_cast<double>(parts[k]) / total;
    boxes += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.0f}\" fill=\"{}\"/>",
                         from, y, width, cell_height - 1.0, shares[k].colour);
    tip += fmt::format("{}{} {}", tip.empty() ? "" : "; ", parts[k], shares[k].label);
    from += width;
  }
  return fmt::format("<g><title>{}</title>{}</g>\n", escaped(tip), boxes);
}

/// Of letters in the pictures' soft text [px].
double text_width(const std::string& text) {
  constexpr double letter = 6.2;
  return letter * static_cast<double>(text.size());
}

std::string panel_title(const LimitMap& map, std::size_t index) {
  return fmt::format("{}: {:g}", map.axes[2].name, map.axes[2].values[index]);
}

/// From one panel's cells to the next one's: room for cells, what is written above and below them, and the
/// next one's labels.
double panel_pitch(const LimitMap& map, std::size_t panels) {
  double inner = cell_width * static_cast<double>(map.axes[0].values.size());
  inner = std::max(inner, text_width(map.axes[0].name));
  for (std::size_t p = 0; p < panels && map.axes.size() > 2; ++p)
    inner = std::max(inner, text_width(panel_title(map, p)));
  return left + inner + gap;
}

double panel_height(const LimitMap& map) {
  const std::size_t rows = map.axes.size() > 1 ? map.axes[1].values.size() : 1;
  return cell_height * static_cast<double>(rows);
}

/// One panel with its origin at the upper left corner of the upper left cell.
std::string panel(const LimitMap& map, std::size_t index) {
  const auto& across = map.axes[0].values;
  const std::vector<double> up = map.axes.size() > 1 ? map.axes[1].values : std::vector<double>{};
  const double height = panel_height(map);
  const double width = cell_width * static_cast<double>(across.size());
  std::string text;
  for (std::size_t i = 0; i < across.size(); ++i) {
    const double x = cell_width * static_cast<double>(i);
    for (std::size_t j = 0; j < std::max<std::size_t>(up.size(), 1); ++j) {
      std::vector<double> at = {across[i]};
      if (!up.empty()) at.push_back(up[j]);
      if (map.axes.size() > 2) at.push_back(map.axes[2].values[index]);
      text += cell(count_at(map, at), x, height - cell_height * static_cast<double>(j + 1));
    }
    text += text_at(x + 0.5 * cell_width, height + 13.0, "middle", fmt::format("{:g}", across[i]),
                    "class=\"small\"");
  }
  for (std::size_t j = 0; j < up.size(); ++j) {
    text += text_at(-5.0, height - cell_height * (static_cast<double>(j) + 0.5) + 4.0, "end",
                    fmt::format("{:g}", up[j]), "class=\"small\"");
  }
  text += text_at(0.5 * width, height + 28.0, "middle", map.axes[0].name, "class=\"soft\"");
  if (map.axes.size() > 1) {
    text +=
        text_at(0.0, 0.0, "middle", map.axes[1].name,
                fmt::format("class=\"soft\" transform=\"translate(-44 {:.1f}) rotate(-90)\"", 0.5 * height));
  }
  if (map.axes.size() > 2) {
    text += text_at(0.0, -7.0, "start", panel_title(map, index), "class=\"soft\"");
  }
  return text;
}

std::string key(double y) {
  std::string text;
  double x = left;
  for (const auto& share : shares) {
    text += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"14\" height=\"12\" fill=\"{}\"/>\n", x,
                        y - 10.0, share.colour);
    text += text_at(x + 20.0, y, "start", share.label, "class=\"soft\"");
    x += 112.0;
  }
  return text;
}

std::string counts_text(const LimitCount& count) {
  return fmt::format("{} right ({} of them flagged), {} uncertain, {} wrong ({} of them flagged), {} refused",
                     count.right, count.false_alarm_text(), count.uncertain, count.wrong,
                     count.flagged_text(), count.refused);
}

}  // namespace

std::string limit_svg(const LimitMap& map) {
  const std::size_t panels = map.axes.size() > 2 ? map.axes[2].values.size() : 1;
  const double panel_width = panel_pitch(map, panels);
  const double row_height = panel_height(map) + 62.0;
  std::string body = text_at(14.0, 22.0, "start", map.title, "class=\"title\"");
  for (std::size_t p = 0; p < panels; ++p) {
    body += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">\n{}</g>\n",
                        left + panel_width * static_cast<double>(p % panels_in_row),
                        top + row_height * static_cast<double>(p / panels_in_row), panel(map, p));
  }
  const auto columns = static_cast<double>(std::min(panels, panels_in_row));
  const double width =
      std::max(left + 112.0 * static_cast<double>(shares.size()) + gap, columns * panel_width + gap);
  double y = top + row_height * static_cast<double>((panels + panels_in_row - 1) / panels_in_row) + 2.0;
  body += key(y);
  y += 20.0;
  body += text_at(14.0, y, "start", counts_text(count_of(map)), "class=\"soft\"");
  for (const auto& line : wrapped(sentence_of(map), static_cast<std::size_t>((width - 28.0) / 6.6))) {
    y += 16.0;
    body += text_at(14.0, y, "start", line);
  }
  return svg_picture(width, y + 14.0, body);
}

}  // namespace struna::apps
