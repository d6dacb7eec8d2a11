// SPDX-License-Identifier: Apache-2.0
// The yardstick of the ray benchmark: Embree 3, medium build quality, single rays and packets of 16. Without Embree the
// class is there but not available().
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lucarium/shared/ray.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium::bench {

class EmbreeScene {
 public:
  /// Builds with `threads` threads; build_seconds() is the wall time of that. `robust`: RTC_SCENE_FLAG_ROBUST, slower
  /// and without gaps between triangles.
  EmbreeScene(std::span<const Vertex> vertices, std::span<const Triangle> triangles, unsigned threads, bool robust);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  static bool available();
  double build_seconds() const;

  /// rtcIntersect1 for every ray, on the calling thread.
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
  /// rtcOccluded1: 1 where something lies within the ray's length.
  void any(std::span<const Ray> rays, std::span<uint32_t> occluded) const;
  /// rtcIntersect16 over consecutive rays with the context flag for coherent rays.
  void closest16(std::span<const Ray> rays, std::span<Hit> hits) const;
  /// rtcOccluded16, likewise.
  void any16(std::span<const Ray> rays, std::span<uint32_t> occluded) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium::bench
