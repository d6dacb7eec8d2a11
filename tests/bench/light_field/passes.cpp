// SPDX-License-Identifier: Apache-2.0
// Where the time of frames of a walk goes.
#include <fmt/format.h>

#include "rendering.h"

namespace lucarium::bench {
namespace {

/// Device time of each pass of a frame, of `rounds` walks [ms].
void show_passes(const std::string& name, const Sizes& sizes) {
  const Scene scene = load_scene(name);
  const auto field = settled(scene, sizes, walkthrough(sizes));
  const bool path = !scene.camera_paths.empty();
  uint32_t frame = 0;
  const auto walk = [&] {
    for (uint32_t i = 0; i < kFrames; ++i)
      if (path)
        next_frame(*field, &frame);
      else
        field->iterate();
    field->scheduler().finish();
  };
  walk();
  field->scheduler().reset_profile();
  for (int round = 0; round < sizes.rounds; ++round) walk();
  const double frames = sizes.rounds * static_cast<double>(kFrames);
  double sum = 0;
  fmt::print("{}\n", name);
  for (const PassProfile& pass : field->scheduler().profile().passes) {
    const double each = 1e3 * pass.device_seconds / frames;
    sum += each;
    if (each > 5e-4) fmt::print("  {:8.3f} ms  {}\n", each, pass.name);
  }
  fmt::print("  {:8.3f} ms  all\n", sum);
}

}  // namespace

void measure_passes(const Sizes& sizes) {
  show_passes("builtin:cornell-mirror", sizes);
  Sizes few = sizes;
  few.dir_n = 2;
  for (const char* count : {"1000", "10000", "100000"})
    show_passes(std::string("builtin:blocks:triangles=") + count, few);
}

}  // namespace lucarium::bench
