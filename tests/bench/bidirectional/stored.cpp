// SPDX-License-Identifier: Apache-2.0
// Look-ups of stored bundles and of maps beside the same rays: device time of the passes, both in turns.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <string>

#include "lucarium/scene/builtin/builder.h"
#include "measures.h"
#include "rendering.h"
#include "room.h"
#include "rounds.h"

namespace lucarium::bench {

Scene make_lit_room() {
  Scene scene = make_full_room();
  const int lamp = add_emitter(scene, "lamp", glm::vec3(10));
  MeshBuilder quad("lamp");
  quad.quad({4, 3.95f, 3}, {6, 3.95f, 3}, {6, 3.95f, 5}, {4, 3.95f, 5});
  add_instance(scene, add_mesh(scene, quad.take()), lamp);
  SceneLight light;
  light.intensity = glm::vec3(100);
  light.world_from_light = glm::translate(glm::mat4(1), glm::vec3(5, 3, 4));
  scene.lights.push_back(light);
  SceneCamera camera;
  camera.yfov = 1.2f;
  camera.world_from_camera = glm::inverse(glm::lookAt(glm::vec3(0.3f, 3, 0.3f), glm::vec3(6, 1, 5), {0, 1, 0}));
  scene.cameras = {camera};
  return scene;
}

namespace {

constexpr uint32_t kWidth = 512;

/// Device seconds of an iteration's passes of one schedule; with `pass` of that one alone.
double seconds_of(const Profile& profile, const std::string& schedule, const std::string& pass = "") {
  double sum = 0;
  for (const PassProfile& one : profile.passes)
    if (one.schedule == schedule && (pass.empty() || one.name == pass)) sum += one.device_seconds;
  return sum;
}

class Profiled {
 public:
  Profiled(const Scene& scene, const Parameters& parameters, int max_bounces)
      : session_(make_session("bidirectional_vpl", scene, kWidth, parameters, max_bounces)) {
    session_->run({.iterations = 1});
  }
  const Profile& next() {
    session_->scheduler().reset_profile();
    session_->run({.iterations = 1});
    return session_->scheduler().profile();
  }

 private:
  std::unique_ptr<RenderSession> session_;
};

void measure_bundles(Bars& bars, const Effort& effort, const Scene& scene) {
  Parameters parameters = {{"directions", "bundle"}, {"bundles", "1"}, {"strategy", "hit"}, {"bundle_res", "512"}};
  Profiled traced(scene, parameters, 0);
  parameters.emplace_back("bundle_mode", "raster");
  Profiled stored(scene, parameters, 0);
  std::vector<double> rays, look_ups;
  for (int round = 0; round < effort.rounds; ++round) {
    rays.push_back(seconds_of(traced.next(), "bounce of camera paths", "closest hit"));
    const Profile& profile = stored.next();
    look_ups.push_back(seconds_of(profile, "views of bundles") + seconds_of(profile, "bundle"));
  }
  bars.note("bundle of 512 x 512 look-ups: rays", 1e3 * median(rays), "ms");
  bars.note("bundle of 512 x 512 look-ups: stored, building included", 1e3 * median(look_ups), "ms");
  bars.add("the rays of a bundle over its look-ups", 1.5, 3, median_ratio(rays, look_ups));
}

void measure_maps(Bars& bars, const Effort& effort, const Scene& scene) {
  Parameters parameters = {{"vpl_choice", "all"}, {"light_vertices", "1"}, {"strategy", "vpl"}};
  Profiled traced(scene, parameters, 1);
  parameters.emplace_back("vpl_visibility", "map");
  Profiled mapped(scene, parameters, 1);
  std::vector<double> rays, maps;
  std::map<std::string, std::vector<double>> parts;
  const std::string connections = "connections to a virtual light";
  for (int round = 0; round < effort.rounds; ++round) {
    rays.push_back(seconds_of(traced.next(), connections, "shadow rays of connections"));
    const Profile& profile = mapped.next();
    maps.push_back(seconds_of(profile, "views of VPL maps") + seconds_of(profile, "face of VPL maps") +
                   seconds_of(profile, connections, "shading.vpl_maps"));
    parts["look-ups"].push_back(seconds_of(profile, connections, "shading.vpl_maps"));
    for (const char* part : {"set_up", "count_bins", "fill_bins", "nearest", "keep"})
      parts[part].push_back(seconds_of(profile, "face of VPL maps", std::string("VPL maps.") + part));
  }
  for (const auto& [name, seconds] : parts) bars.note("of which " + name, 1e3 * median(seconds), "ms");
  bars.note("21 virtual lights: shadow rays", 1e3 * median(rays), "ms");
  bars.note("21 virtual lights: maps, building included", 1e3 * median(maps), "ms");
  bars.add("shadow rays to virtual lights over their maps", 1, 2, median_ratio(rays, maps));
}

}  // namespace

void measure_stored(Bars& bars, const Effort& effort) {
  const Scene scene = make_lit_room();
  bars.note("room, triangles", static_cast<double>(scene.triangle_count()), "");
  measure_bundles(bars, effort, scene);
  measure_maps(bars, effort, scene);
}

}  // namespace lucarium::bench
