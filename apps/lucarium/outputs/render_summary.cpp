// SPDX-License-Identifier: Apache-2.0
#include "outputs/render_summary.h"

#include <algorithm>

#include "budgets/curve_recorder.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/exposure.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// Where the time went, longest first.
ordered_json passes_json(RenderSession& session) {
  session.scheduler().finish();
  std::vector<PassProfile> passes = session.scheduler().profile().passes;
  std::stable_sort(passes.begin(), passes.end(),
                   [](const PassProfile& a, const PassProfile& b) { return a.device_seconds > b.device_seconds; });
  ordered_json json = ordered_json::array();
  for (const PassProfile& pass : passes) {
    if (pass.count == 0) continue;
    json.push_back({{"schedule", pass.schedule},
                    {"name", pass.name},
                    {"device_seconds", pass.device_seconds},
                    {"count", pass.count}});
  }
  return json;
}

/// What was planned for a budget of time, or null.
ordered_json plan_json(const BudgetPlan& plan) {
  if (plan.budget_seconds <= 0) return nullptr;
  const auto changed = [](const std::vector<BudgetPlan::Change>& changes) {
    ordered_json list = ordered_json::array();
    for (const BudgetPlan::Change& change : changes)
      list.push_back({{"parameter", change.parameter}, {"from", change.from}, {"to", change.to}});
    return list;
  };
  return {{"budget_seconds", plan.budget_seconds},     {"default_seconds", plan.default_seconds},
          {"expected_seconds", plan.expected_seconds}, {"sufficient_seconds", plan.sufficient_seconds},
          {"changes", changed(plan.changes)},          {"lifted", changed(plan.lifted)}};
}

}  // namespace

ordered_json frame_json(RenderSession& session, const Film& film, const RenderEnd& end, double load_seconds,
                        double total_seconds, float exposure, const std::vector<fs::path>& files) {
  const MemoryAccount& memory = session.scheduler().device().memory();
  const RenderSession::Clocks& clocks = session.clocks();
  ordered_json json;
  for (const auto& [key, value] : film.metadata) json[key] = value;
  json["width"] = film.width();
  json["height"] = film.height();
  json["samples"] = session.last().samples;
  json["iterations"] = session.iterations();
  json["seed"] = session.settings().seed;
  json["max_bounces"] = session.settings().max_bounces;
  json["pixel_sampling"] = session.settings().pixel_sampling;
  json["scene_time_seconds"] = session.scene().time;
  const Scene& scene = session.scene();
  json["camera"] = scene.camera_path ? ordered_json(camera_text(sample_camera_path(*scene.camera_path, scene.time)))
                                     : ordered_json(nullptr);
  json["exposure_stops"] = exposure;
  json["exposure_automatic"] = is_automatic(session.scene().exposure);
  json["partial"] = film.metadata.count("partial") > 0;
  json["converged"] = session.last().converged;
  json["progress"] = session.last().progress < 0 ? ordered_json(nullptr) : ordered_json(session.last().progress);
  json["phase"] = session.last().phase;
  json["ended_by"] = end.by;
  json["seconds_left"] = end.seconds_left ? ordered_json(*end.seconds_left) : ordered_json(nullptr);
  json["seconds"] = total_seconds;
  json["clocks"] = {
      {"load_seconds", load_seconds},      {"upload_seconds", clocks.upload},   {"bvh_seconds", clocks.bvh},
      {"compile_seconds", clocks.compile}, {"prepare_seconds", clocks.prepare}, {"warm_up_seconds", clocks.warm_up},
      {"state_seconds", clocks.load},      {"light_seconds", clocks.light},     {"iterate_seconds", clocks.iterate}};
  if (const auto processor = processor_seconds_of(session)) json["clocks"]["processor_seconds"] = *processor;
  json["device_memory_bytes"] = memory.by_owner();
  json["peak_device_memory_bytes"] = memory.peak_bytes();
  json["passes"] = passes_json(session);
  json["plan"] = plan_json(session.plan());
  json["counters"] = session.technique().counters();
  json["limitations"] = session.limitations();
  json["warnings"] = session.scene().warnings;
  json["files"] = ordered_json::array();
  for (const fs::path& file : files) json["files"].push_back(file.string());
  return json;
}

ordered_json summary_json(const ordered_json& frames) { return {{"schema", "lucarium-render-2"}, {"frames", frames}}; }

}  // namespace lucarium::app
