// SPDX-License-Identifier: Apache-2.0
// Sweeps of fields, one after the other, without pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "bars.h"
#include "field_rig.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "room.h"
#include "rounds.h"
#include "through_rays.h"

namespace lucarium::bench {
namespace {

constexpr size_t kCache = size_t{1} << 31;  // for kept fragments, where some are kept [bytes]

/// A field whose propagation does not end.
vlf::Parameters endless(int dir_n, int cells) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = cells;
  parameters.texels = 262144;
  parameters.access_rays = 128;
  parameters.residual = 0;
  parameters.cache_visibility = 0;
  parameters.direct_mode = vlf::DirectMode::exchange;
  parameters.preview = false;
  return parameters;
}

std::unique_ptr<test::FieldRig> make_rig(const Scene& scene, const vlf::Parameters& parameters, size_t cache = 0) {
  test::FieldRig::Options options;
  options.cache_bytes = cache;
  return std::make_unique<test::FieldRig>(scene, parameters, options);
}

/// One sweep more; of a field that has ended, the first of another.
void sweep(test::FieldRig& rig) {
  if (rig.field().done()) rig.restart();
  rig.propagate(rig.field().sweeps() + 1);
}

Contestant sweeping(test::FieldRig& rig, unsigned cpus = 2) {
  return {.name = "sweep", .run = [&rig] { sweep(rig); }, .cpus = cpus};
}

/// The room of 70 000 triangles, with a lamp.
Scene lit_room() {
  Scene scene = make_full_room();
  const int lamp = add_emitter(scene, "lamp", glm::vec3(10));
  MeshBuilder quad("lamp");
  quad.quad({4, 3.95f, 3}, {6, 3.95f, 3}, {6, 3.95f, 5}, {4, 3.95f, 5});
  add_instance(scene, add_mesh(scene, quad.take()), lamp);
  return scene;
}

/// The rasters of lines, as SubfieldRuns makes them.
std::vector<LayeredView> views_of(const test::FieldRig& rig) {
  const vlf::SubfieldPlan& subfield = rig.surfaces().subfield;
  const auto pixels = static_cast<float>(1u << subfield.shift);
  const auto times = [&](const float4& r) { return float4(r.x * pixels, r.y * pixels, r.z * pixels, r.w * pixels); };
  const double range = 2.002 * static_cast<double>(rig.scene().bounds().radius()) + 1e-6;
  std::vector<LayeredView> views;
  for (const FieldLine& line : rig.field().maps().host_lines()) {
    LayeredView& view = views.emplace_back();
    view.row_x = times(line.row_x);
    view.row_y = times(line.row_y);
    view.row_w = line.row_w;
    view.depth_min = static_cast<float>(-0.5 * range);
    view.depth_scale = static_cast<float>(1 / range);
    view.width = view.height = subfield.cells << subfield.shift;
  }
  return views;
}

void measure_threads(Bars& bars, const Sizes& sizes, test::FieldRig& rig) {
  std::vector<Contestant> all{sweeping(rig, 1), sweeping(rig, 2)};
  run_rounds(all, sizes.rounds);
  const auto fastest = [](const Contestant& c) { return *std::min_element(c.wall.begin(), c.wall.end()); };
  bars.add("sweep, two threads over one (elapsed, fastest)", 1.6, 1.9, fastest(all[0]) / fastest(all[1]));
}

/// Sweeps by raster, by kept fragments, and all rays of their pixels by the hierarchy.
void measure_rays(Bars& bars, const Sizes& sizes) {
  vlf::Parameters parameters = endless(3, static_cast<int>(sizes.subfield / 8));
  parameters.supersample = vlf::Supersample::eight;
  const Scene scene = lit_room();
  const auto drawn = make_rig(scene, parameters), kept = make_rig(scene, parameters, kCache);
  sweep(*drawn);
  sweep(*kept);  // keeps fragments first
  const std::vector<LayeredView> views = views_of(*drawn);
  const TypedBuffer<LayeredView> buffer(drawn->device(), "bench", "views", views);
  ThroughRays rays(drawn->scheduler(), drawn->bvh(), buffer, views.front().width * views.front().height);
  double hits = 0;
  std::vector<Contestant> all{sweeping(*drawn), sweeping(*kept)};
  all.push_back({.name = "rays",
                 .run =
                     [&] {
                       hits = 0;
                       for (uint32_t view = 0; view < views.size(); ++view) hits += rays.trace(view);
                     },
                 .cpus = 2});
  run_rounds(all, sizes.rounds);
  const double lines = static_cast<double>(views.size());
  bars.note("room, triangles", static_cast<double>(scene.triangle_count()), "");
  bars.note("room, pixels along a subfield's edge", views.front().width, "");
  bars.note("room, lines whose fragments are kept", static_cast<double>(kept->field().counts().kept_subfields),
            "of " + std::to_string(views.size()));
  bars.note("room, a line of a sweep by raster, processor time", 1e3 * median(all[0].cpu) / lines, "ms");
  bars.note("room, rays of pixels by raster, processor time", 1e-6 * hits / median(all[0].cpu), "M/s", 33);
  bars.add("sweep by raster over sweep by kept fragments", 2, 4, median_ratio(all[0].cpu, all[1].cpu));
  bars.add("the same rays through the hierarchy over a sweep by raster", 6, 15, median_ratio(all[2].cpu, all[0].cpu));
  bars.add("the same rays through the hierarchy over a sweep by kept fragments", 12, 30,
           median_ratio(all[2].cpu, all[1].cpu));
  measure_threads(bars, sizes, *drawn);
}

/// Propagations to so many sweeps, each from its beginning, in turns with what prepares them.
std::vector<Contestant> beginnings(std::vector<std::unique_ptr<test::FieldRig>>& rigs, uint32_t sweeps) {
  std::vector<Contestant> all;
  for (auto& rig : rigs) {
    all.push_back({.name = "restart", .run = [&rig] { rig->restart(); }, .cpus = 2});
    all.push_back({.name = "sweeps", .run = [&rig, sweeps] { rig->propagate(sweeps); }, .cpus = 2});
  }
  return all;
}

void measure_lights(Bars& bars, const Sizes& sizes) {
  std::vector<std::unique_ptr<test::FieldRig>> lamps, skies;
  for (const char* name : {"builtin:lamps-1", "builtin:lamps-100"})
    lamps.push_back(make_rig(load_scene(name), endless(sizes.dir_n, 0)));
  SceneOverrides sky;
  sky.environment = "1,1.2,1.5";
  for (const SceneOverrides& overrides : {SceneOverrides{}, sky})
    skies.push_back(make_rig(load_scene("builtin:cornell", overrides), endless(sizes.dir_n, 0)));
  const auto ratio = [&](std::vector<std::unique_ptr<test::FieldRig>>& rigs) {
    std::vector<Contestant> all = beginnings(rigs, 3);
    run_rounds(all, 1);
    for (Contestant& c : all) c.cpu.clear(), c.wall.clear();
    run_rounds(all, sizes.rounds);
    return median_ratio(all[3].cpu, all[1].cpu);
  };
  bars.add("three sweeps, 100 lamps over 1", 1.2, 1.05, ratio(lamps), true);
  bars.add("three sweeps, with sky over without", 1.2, 1.05, ratio(skies), true);
}

/// Device time of each pass of a line, of `rounds` sweeps [ms].
void show_line(const std::string& name, const Sizes& sizes, test::FieldRig& rig, const std::function<void()>& run) {
  run();
  rig.scheduler().reset_profile();
  for (int round = 0; round < sizes.rounds; ++round) run();
  const double lines = sizes.rounds * static_cast<double>(rig.field().maps().host_lines().size());
  double sum = 0;
  fmt::print("{}\n", name);
  for (const PassProfile& pass : rig.scheduler().profile().passes) {
    const double each = 1e3 * pass.device_seconds / lines;
    sum += each;
    if (each > 5e-3) fmt::print("  {:8.3f} ms  {}\n", each, pass.name);
  }
  fmt::print("  {:8.3f} ms  all\n", sum);
}

}  // namespace

void measure_lines(const Sizes& sizes) {
  vlf::Parameters parameters = endless(3, static_cast<int>(sizes.subfield / 8));
  parameters.supersample = vlf::Supersample::eight;
  const Scene scene = lit_room();
  for (const size_t cache : {size_t{0}, kCache}) {
    const auto rig = make_rig(scene, parameters, cache);
    show_line(cache > 0 ? "room, fragments kept" : "room, by raster", sizes, *rig, [&] { sweep(*rig); });
  }
  for (const char* name : {"builtin:lamps-1", "builtin:lamps-100"}) {
    const auto rig = make_rig(load_scene(name), endless(sizes.dir_n, 0));
    show_line(std::string(name) + ", three sweeps", sizes, *rig, [&] {
      rig->restart();
      rig->propagate(3);
    });
  }
}

void measure_sweeps(Bars& bars, const Sizes& sizes) {
  measure_rays(bars, sizes);
  measure_lights(bars, sizes);
}

}  // namespace lucarium::bench
