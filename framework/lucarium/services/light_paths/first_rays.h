// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/primitives/primitives.h"

namespace lucarium {

/// Traces first rays of light paths from point and spot lights in the order of lights and directions, in which runs of
/// them are coherent, and returns their hits as paths are numbered. Hits are those without it, bit for bit.
class FirstRays {
 public:
  static constexpr uint32_t kFewest = 1 << 16;  ///< of fewer, neighbours are too far apart

  explicit FirstRays(Device& device);

  /// Whether the order is worth its own time: `paths` at once, most of them from such lights, among those of `kinds`
  /// (bits 1 << LUCARIUM_LIGHT_*).
  static bool pays(const SceneBuffers& scene, const Intersector& intersector, uint32_t paths, uint32_t kinds);

  /// Of each ray its key and its number, which emit_light_paths fills.
  struct Keys {
    BufferRef keys, order;
  };
  static Keys keys(ScheduleRecorder& recorder, uint32_t rays, const std::string& remedy);

  void record(ScheduleRecorder& recorder, const std::string& pass_name, const Intersector& intersector,
              const RayBuffers& rays, const Keys& keys, const BufferRef& hits, const std::string& remedy) const;
  static size_t estimate_bytes(uint32_t paths);

 private:
  Primitives primitives_;
  Program program_;
};

}  // namespace lucarium
