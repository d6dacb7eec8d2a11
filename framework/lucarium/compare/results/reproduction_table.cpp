// SPDX-License-Identifier: Apache-2.0
// What `lucarium reproduce` prints. Declared in reproduction.h.
#include <algorithm>
#include <cmath>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/compare/results/reproduction.h"

namespace lucarium {

namespace {

std::string number_text(double value) { return std::isnan(value) ? "–" : fmt::format("{:.4g}", value); }

/// A row for each variant, a column for each place on the horizontal axis, and the slope.
std::string plot_table(const Reproduction::Plot& plot) {
  std::set<double> columns;  // in ascending order
  size_t width = 0;
  for (const Reproduction::Line& line : plot.lines) {
    width = std::max(width, line.label.size());
    for (const Reproduction::Point& point : line.points) columns.insert(point.x);
  }
  std::string text = fmt::format("  {}: {} over {}\n  {:{}}", plot.title, plot.y_label, plot.x_label, "", width);
  for (const double x : columns) text += fmt::format("  {:>10}", number_text(x));
  text += fmt::format("  {:>10}\n", "slope");
  for (const Reproduction::Line& line : plot.lines) {
    text += fmt::format("  {:{}}", line.label, width);
    for (const double x : columns) {
      const auto found = std::find_if(line.points.begin(), line.points.end(),
                                      [x](const Reproduction::Point& point) { return point.x == x; });
      text += fmt::format("  {:>10}", number_text(found == line.points.end() ? NAN : found->y));
    }
    text += fmt::format("  {:>10}\n", std::isnan(line.slope) ? "–" : fmt::format("{:.2f}", line.slope));
  }
  return text;
}

}  // namespace

std::string Reproduction::table() const {
  std::string text = fmt::format("{} ({}{}): {}\n  {} {}\n", id, place, quick ? ", quick setting" : "", title,
                                 own ? "claim:" : "paper:", claim);
  if (!differences.empty()) text += fmt::format("  here:  {}\n", differences);
  size_t width = 0;
  for (const Value& value : values) width = std::max(width, value.label.size());
  if (!values.empty())
    text += fmt::format("  {:{}}  {:>12}{}\n", "", width, "measured", own ? "" : fmt::format("  {:>12}", "paper"));
  for (const Value& value : values) {
    text += fmt::format("  {:{}}  {:>12}{}  {}\n", value.label, width, number_text(value.ours),
                        own ? "" : fmt::format("  {:>12}", number_text(value.paper.value_or(NAN))), value.unit);
  }
  for (const Plot& plot : plots) text += plot_table(plot);
  for (const Trend& trend : trends)
    text += fmt::format("  {}{}: {}  [{}]\n", trend.verdict, trend.unlike_machines ? ", since the machines differ" : "",
                        trend.claim, trend.expression);
  return text;
}

}  // namespace lucarium
