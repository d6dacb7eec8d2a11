// SPDX-License-Identifier: Apache-2.0
#include "bars.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace lucarium::bench {

void Bars::add(const std::string& what, double floor, double goal, double value, bool at_most) {
  if (rows_.empty()) fmt::print("| what | floor | goal | value | reached |\n|---|---|---|---|---|\n");
  const Row& row = rows_.emplace_back(Row{what, {}, floor, goal, value, 0, at_most, true});
  const char* sign = at_most ? "≤ " : "";
  const std::string shown = std::isfinite(value) ? fmt::format("{:.3g}", value) : "–";
  fmt::print("| {} | {}{} | {}{} | {} | {} |\n", what, sign, floor, sign, goal, shown, verdict(row));
  std::fflush(stdout);
}

void Bars::note(const std::string& what, double value, const std::string& unit, double paper) {
  rows_.push_back({what, unit, 0, 0, value, paper, false, false});
  if (paper > 0)
    fmt::print("{}: {:.4g} {} (paper {:.4g})\n", what, value, unit, paper);
  else
    fmt::print("{}: {:.4g} {}\n", what, value, unit);
  std::fflush(stdout);
}

const char* Bars::verdict(const Row& row) const {
  const auto reached = [&](double bar) { return row.at_most ? row.value <= bar : row.value >= bar; };
  return !std::isfinite(row.value) ? "no" : reached(row.goal) ? "goal" : reached(row.floor) ? "floor" : "no";
}

std::string Bars::json() const {
  nlohmann::json all = nlohmann::json::array();
  for (const Row& row : rows_) {
    nlohmann::json entry{{"what", row.what}, {"value", row.value}};
    if (row.is_bar) {
      entry["floor"] = row.floor;
      entry["goal"] = row.goal;
      entry["at_most"] = row.at_most;
      entry["reached"] = verdict(row);
    } else {
      entry["unit"] = row.unit;
      if (row.paper > 0) entry["paper"] = row.paper;
    }
    all.push_back(entry);
  }
  return all.dump(1) + "\n";
}

}  // namespace lucarium::bench
