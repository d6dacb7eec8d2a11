// SPDX-License-Identifier: Apache-2.0
// A scene with its atlas on the device, and points to look up in it.
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "support.h"

const lucarium::EmbeddedSources& test_services_kernels();

namespace lucarium::test {

/// A scene with its atlas.
struct AtlasContext {
  AtlasContext(Scene scene_, uint64_t texels)
      : scene(std::move(scene_)), scheduler(test_device()), buffers(*test_device(), scene) {
    options.texel_count = texels;
    atlas = std::make_unique<SurfaceAtlas>(*test_device(), scheduler, scene, buffers, options, "test");
  }
  Scene scene;
  KernelScheduler scheduler;
  SceneBuffers buffers;
  SurfaceAtlasOptions options;
  std::unique_ptr<SurfaceAtlas> atlas;
};

/// Random points of random triangles.
struct Points {
  std::vector<uint32_t> triangles;
  std::vector<float2> points;
};

inline Points random_points(size_t triangle_count, size_t count) {
  std::mt19937 random(3);
  Points result;
  for (size_t i = 0; i < count; ++i) {
    result.triangles.push_back(static_cast<uint32_t>(random() % triangle_count));
    const RandomPoint p = random_point(random);
    result.points.emplace_back(p.b1, p.b2);
  }
  return result;
}

/// tests/framework/services/surface_atlas/surface_atlas.cl.
inline Program lookup_program() {
  SourceLibrary library;
  library.add(test_services_kernels());
  return Program(*test_device(), library,
                 {"test_services/surface_atlas", {"test_services/surface_atlas/surface_atlas.cl"}, {}});
}

/// Runs one of its kernels at these points of triangles, with the further arguments that `bind(PassBuilder&)` gives.
template <class Bind>
void run_at(AtlasContext& context, const std::string& kernel, const Points& p, Bind bind) {
  const auto triangles = test_buffer(p.triangles);
  const auto points = test_buffer(p.points);
  const uint32_t count = static_cast<uint32_t>(p.points.size());
  const Program program = lookup_program();
  ScheduleRecorder recorder = context.scheduler.record(kernel, "test");
  PassBuilder pass = recorder.pass(kernel, program, kernel);
  context.atlas->bind(pass);
  pass.global(count).local(64).arg("triangles", triangles).arg("points", points).arg("count", count);
  bind(pass);
  Schedule schedule = recorder.compile();
  context.scheduler.run(schedule);
  context.scheduler.finish();
}

}  // namespace lucarium::test
