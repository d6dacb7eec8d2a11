// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "lucarium/base/json.h"

namespace lucarium {
namespace {

double per_count(double sum, uint64_t count) { return count ? sum / static_cast<double>(count) : 0; }

}  // namespace

std::string Profile::table() const {
  std::vector<size_t> order(passes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return passes[a].device_seconds > passes[b].device_seconds; });
  size_t width = 4;
  double total = 0;
  for (const PassProfile& pass : passes) total += pass.device_seconds;
  for (const PassProfile& pass : passes) width = std::max(width, pass.schedule.size() + 1 + pass.name.size());

  std::string text;
  text += fmt::format("{:<{}}  {:>8}  {:>11}  {:>6}  {:>11}  {:>11}  {:>8}  {}\n", "pass", width, "count", "device s",
                      "share", "ms each", "launch us", "GB/s", "kernel");
  for (const size_t index : order) {
    const PassProfile& pass = passes[index];
    const std::string rate = pass.bytes > 0 && pass.device_seconds > 0
                                 ? fmt::format("{:.2f}", pass.bytes / pass.device_seconds * 1e-9)
                                 : "-";
    text += fmt::format("{:<{}}  {:>8}  {:>11.6f}  {:>4.1f} %  {:>11.4f}  {:>11.2f}  {:>8}  {}\n",
                        pass.schedule + "/" + pass.name, width, pass.count, pass.device_seconds,
                        total > 0 ? 100 * pass.device_seconds / total : 0.0,
                        1e3 * per_count(pass.device_seconds, pass.count),
                        1e6 * per_count(pass.launch_seconds, pass.count), rate, pass.kernel);
  }
  text += fmt::format("{} runs, {:.6f} s wall time (passes may overlap: their times do not add up to it)\n", runs,
                      wall_seconds);
  return text;
}

std::string Profile::json() const {
  nlohmann::ordered_json document;
  document["runs"] = runs;
  document["wall_seconds"] = wall_seconds;
  document["passes"] = nlohmann::ordered_json::array();
  for (const PassProfile& pass : passes) {
    document["passes"].push_back({{"schedule", pass.schedule},
                                  {"name", pass.name},
                                  {"kernel", pass.kernel},
                                  {"count", pass.count},
                                  {"device_seconds", pass.device_seconds},
                                  {"launch_seconds", pass.launch_seconds},
                                  {"moved_bytes", pass.bytes}});
  }
  return document.dump(2);
}

std::string Profile::chrome_trace() const {
  std::vector<const PassEvent*> order;
  for (const PassEvent& event : events) order.push_back(&event);
  std::stable_sort(order.begin(), order.end(),
                   [](const PassEvent* a, const PassEvent* b) { return a->started_ns < b->started_ns; });
  const uint64_t origin = order.empty() ? 0 : order.front()->started_ns;

  nlohmann::ordered_json trace = nlohmann::ordered_json::array();
  std::vector<uint64_t> lane_end;  // events that overlap in time get lanes of their own
  for (const PassEvent* event : order) {
    const auto lane =
        std::find_if(lane_end.begin(), lane_end.end(), [&](uint64_t end) { return end <= event->started_ns; });
    const auto lane_number = lane - lane_end.begin();
    if (lane == lane_end.end()) {
      lane_end.push_back(event->ended_ns);
    } else {
      *lane = event->ended_ns;
    }
    const PassProfile& pass = passes[static_cast<size_t>(event->pass)];
    trace.push_back({{"name", pass.name},
                     {"cat", pass.schedule},
                     {"ph", "X"},
                     {"pid", 0},
                     {"tid", lane_number},
                     {"ts", static_cast<double>(event->started_ns - origin) * 1e-3},
                     {"dur", static_cast<double>(event->ended_ns - event->started_ns) * 1e-3},
                     {"args", {{"kernel", pass.kernel}, {"run", event->run}}}});
  }
  return nlohmann::ordered_json{{"traceEvents", trace}, {"displayTimeUnit", "ms"}}.dump();
}

}  // namespace lucarium
