// SPDX-License-Identifier: Apache-2.0
// Pictures of a scene's first camera by a technique that is loaded as a plug-in.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/session/session.h"
#include "registry.h"

namespace lucarium::test {

using Parameters = std::vector<std::pair<std::string, std::string>>;

struct Picture {
  std::string technique = "voxel_abuffer";
  uint32_t size = 16;
  uint64_t iterations = 1, seed = 1;
  int max_bounces = 0;
  uint32_t pixel_sampling = RenderSettings().pixel_sampling;
  DeviceOptions device;
};

inline std::unique_ptr<RenderSession> session(const Scene& scene, const Picture& picture, Parameters parameters) {
  RenderSettings settings;
  settings.width = settings.height = picture.size;
  settings.max_bounces = picture.max_bounces;
  settings.seed = picture.seed;
  settings.pixel_sampling = picture.pixel_sampling;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(Device::open(picture.device), scene, registry().find(picture.technique),
                                         settings, parameters);
}

inline Film render(const Scene& scene, const Picture& picture, Parameters parameters) {
  const std::unique_ptr<RenderSession> run = session(scene, picture, std::move(parameters));
  for (uint64_t i = 0; i < picture.iterations; ++i) run->iterate();
  return run->resolve();
}

/// `count` independent pictures, of the seeds from `picture.seed` on.
inline std::vector<std::vector<float>> pictures(const Scene& scene, const Picture& picture, Parameters parameters,
                                                uint32_t count) {
  const std::unique_ptr<RenderSession> run = session(scene, picture, std::move(parameters));
  std::vector<std::vector<float>> all;
  for (uint32_t i = 0; i < count; ++i) {
    if (i > 0) run->restart(picture.seed + i);
    run->run({.iterations = picture.iterations});
    all.push_back(run->resolve().image());
  }
  return all;
}

}  // namespace lucarium::test
