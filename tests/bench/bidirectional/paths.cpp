// SPDX-License-Identifier: Apache-2.0
// Errors of path_tracing over those of bidirectional_vpl at equal processor time, and of its preset bdpt beside.
#include <cstdlib>
#include <filesystem>

#include "lucarium/statistics/statistics.h"
#include "subject.h"

namespace lucarium::bench {
namespace {

constexpr uint64_t kTimesAsMany = 4;  ///< samples of a path-traced picture, whose errors spread most

void measure_scene(Bars& bars, const Effort& effort, const std::string& name, const Scene& scene, double floor,
                   double goal) {
  const Subject subject(name, scene, 4, effort, {});
  const std::vector<Measured> of = subject.measure({{{}, kTimesAsMany * effort.samples, "path_tracing"},
                                                    {{}, effort.samples},
                                                    {{{"preset", "bdpt"}}, effort.samples}});
  add_ratio(bars, name + ": path_tracing over the default", floor, goal, of[0].costs, of[1].costs);
  const ConfidenceInterval bdpt = paired_ratio(of[0].costs, of[2].costs);
  bars.note(name + ": path_tracing over bdpt", bdpt.mean, "");
  bars.note(name + ": path_tracing over bdpt, 95 % interval from", bdpt.low, "");
  bars.note(name + ": path_tracing over bdpt, 95 % interval to", bdpt.high, "");
}

}  // namespace

void measure_paths(Bars& bars, const Effort& effort) {
  const struct {
    const char *name, *scene;
    double floor, goal;
  } all[] = {{"room", "builtin:room", 3, 8},
             {"room, lamp of 4 cm", "builtin:room:lamp=1", 3, 10},
             {"room, point light 2 cm from a wall", "builtin:room:lamp=2", 50, 400},
             {"room, spot at the ceiling", "builtin:room:lamp=3", 50, 300},
             {"fixture, point light", "builtin:fixture", 20, 80},
             {"fixture, lamp of 4 cm", "builtin:fixture:lamp=1", 20, 80},
             {"caustic", "builtin:caustic", 20, 100},
             {"Cornell box", "builtin:cornell", 1, 2},
             {"atrium, sun and sky", "builtin:atrium", 0.6, 0.95}};
  for (const auto& one : all) {
    if (!effort.scene.empty() && effort.scene != one.scene) continue;
    measure_scene(bars, effort, one.name, load_scene(one.scene), one.floor, one.goal);
  }
  // Not a part of the repository.
  const char* const shared = std::getenv("LUCARIUM_TEST_SHARED");
  const std::string sponza = std::string(shared ? shared : "../shared") + "/scenes/scenes/sponza_crytek/sponza.gltf";
  if (!std::filesystem::exists(sponza) || (!effort.scene.empty() && effort.scene != "sponza")) return;
  SceneOverrides overrides;
  overrides.environment = "1";
  overrides.camera = "-10,2,-0.4:8,4.5,0:57";
  measure_scene(bars, effort, "Sponza by a sky", load_scene(sponza, overrides), 0.6, 0.95);
}

}  // namespace lucarium::bench
