// SPDX-License-Identifier: Apache-2.0
// Path tracing end to end, 640×360 at 64 samples per pixel: samples and rays per second. Sponza where the third-party
// scenes are (LUCARIUM_TEST_SHARED, default ../shared below the working directory), builtin:atrium always.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>

#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/session.h"

namespace {

using namespace lucarium;

void render(benchmark::State& state, const std::string& source, const SceneOverrides& overrides) {
  const TechniqueRegistry registry;
  RenderSettings settings;
  Scene scene = load_scene(source, overrides);
  settings.camera = scene.cameras.front();
  RenderSession session(Device::open(), std::move(scene), registry.find("path_tracing"), settings,
                        {{"samples_per_iteration", "4"}});
  double rays = 0;
  uint64_t samples = 0;
  for (auto _ : state) {
    const auto before = session.technique().counters();
    const uint64_t had = session.last().samples;
    session.run({0, 0, had + 64});
    const auto after = session.technique().counters();
    rays += after.at("closest_rays") + after.at("shadow_rays") - before.at("closest_rays") - before.at("shadow_rays");
    samples += (session.last().samples - had) * settings.width * settings.height;
  }
  state.counters["rays/s"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
  state.counters["samples/s"] = benchmark::Counter(static_cast<double>(samples), benchmark::Counter::kIsRate);
}

const bool registered = [] {
  const auto add = [](const char* name, const std::string& source, const SceneOverrides& overrides) {
    benchmark::RegisterBenchmark(name, [=](benchmark::State& state) { render(state, source, overrides); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Iterations(1)
        ->Repetitions(3);
  };
  add("path_tracing/atrium", "builtin:atrium", {});
  const char* shared = std::getenv("LUCARIUM_TEST_SHARED");
  const auto sponza = std::filesystem::path(shared ? shared : "../shared") / "scenes/scenes/sponza_crytek/sponza.gltf";
  if (std::filesystem::exists(sponza)) {
    SceneOverrides overrides;
    overrides.camera = "-10,2,-0.4:8,4.5,0:57";
    overrides.lights = {"directional:0.20,-0.96,0.18:20,20,20"};
    overrides.environment = "0.5,0.5,0.5";
    add("path_tracing/sponza", sponza.string(), overrides);
  }
  return true;
}();

}  // namespace
