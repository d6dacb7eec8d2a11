// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "lucarium/shared/gbuffer.h"

namespace lucarium {

/// Per-pixel first non-delta surface point (G-buffer: Saito and Takahashi 1990): delta events (mirror, ideal
/// refraction) from the eye are followed (they are free, at most LUCARIUM_PATH_EYE_DELTA_LIMIT), their throughput is
/// kept. One camera sample per pixel and call; sub-pixel positions follow the frame's pixel_sampling and the sample
/// index, the same for every technique. Changes of the scene need no new one while the generations of SceneBuffers and
/// of the intersector stay.
class GBuffer {
 public:
  /// `first_surface`: the first surface is kept even where it is a mirror or glass, and no delta event is followed.
  GBuffer(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
          const Frame& frame, const std::string& owner, bool first_surface = false);
  ~GBuffer();

  /// Fills `points()` for sample `sample_index`. Returns false when cancelled midway: the points are then useless.
  bool render(uint32_t sample_index);
  /// Another camera or seed; the image size stays.
  void set_frame(const Frame& frame);
  void warm_up();
  const TypedBuffer<GBufferPoint>& points() const;  ///< width · height, rows from the top
  /// Writes Albedo, P, N, Ns AOVs of the last render.
  void resolve(Film& film) const;
  /// `ray_ends`: over an intersector that wants them.
  static size_t estimate_bytes(uint32_t width, uint32_t height, bool ray_ends = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
