// SPDX-License-Identifier: Apache-2.0
// Milliseconds to build a hierarchy, and to follow the rigid motion of one instance, on builtin:atrium.
#include <benchmark/benchmark.h>

#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/services/bvh/bvh.h"

namespace {

using namespace lucarium;

void bvh_build(benchmark::State& state) {
  const std::shared_ptr<Device> device = Device::open();
  const Scene scene = load_scene("builtin:atrium");
  const SceneBuffers buffers(*device, scene);
  for (auto _ : state) benchmark::DoNotOptimize(Bvh(*device, scene, buffers).statistics().nodes);
  state.counters["triangles"] = static_cast<double>(scene.triangle_count());
}
BENCHMARK(bvh_build)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The instance with the most triangles moves; its node is the target of an animation.
void bvh_motion(benchmark::State& state) {
  const std::shared_ptr<Device> device = Device::open();
  Scene scene = load_scene("builtin:atrium");
  int mover = 0;
  for (int i = 0; i < static_cast<int>(scene.instances.size()); ++i) {
    const auto triangles = [&](int j) { return scene.instances[j].shape(scene).triangles.size(); };
    if (triangles(i) > triangles(mover)) mover = i;
  }
  SceneInstance& instance = scene.instances[mover];
  if (instance.node == none) {
    instance.node = static_cast<int>(scene.nodes.size());
    scene.nodes.emplace_back().matrix = instance.world_from_object;
  }
  AnimationChannel channel;
  channel.node = instance.node;
  channel.times = {0};
  channel.values = {0, 0, 0};
  scene.animations.emplace_back().channels = {channel};
  evaluate(scene, 0, none);
  SceneBuffers buffers(*device, scene);
  Bvh bvh(*device, scene, buffers);
  const glm::mat4 place = instance.world_from_object;
  int step = 0;
  for (auto _ : state) {
    state.PauseTiming();
    scene.nodes[instance.node].matrix =
        glm::translate(glm::mat4(1.f), glm::vec3(0.1f * static_cast<float>(++step % 10), 0, 0)) * place;
    const SceneChange change = evaluate(scene, 0, none);
    buffers.update(scene, change);
    state.ResumeTiming();
    bvh.update(scene, buffers, change);
  }
  state.counters["moved triangles"] = static_cast<double>(instance.shape(scene).triangles.size());
  state.counters["builds"] = static_cast<double>(bvh.statistics().part_builds);
}
BENCHMARK(bvh_motion)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
