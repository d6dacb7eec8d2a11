// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "lucarium/shared/camera.h"

namespace lucarium::abuffer {

/// What a mode works with; all but the frame outlive it.
struct ModeContext {
  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  const Intersector& intersector;
  const Intersector& primary;  ///< of camera rays: the same, or what knows them from a raster
  Frame frame;
  uint32_t pixels() const { return frame.width * frame.height; }
};

/// A way of light transport over an intersector (Hu et al. 2014, section 4): an image that grows by passes of λ
/// samples per pixel (algorithm 1 there).
class Mode {
 public:
  virtual ~Mode() = default;
  /// Adds a pass. False when cancelled: nothing has been added then.
  virtual bool pass() = 0;
  /// Back to no passes, with this camera and seed; the image size stays.
  virtual void restart(const Frame& frame, uint64_t seed) = 0;
  /// Follows a change of the scene, while the generations of scene and intersector stay; restart() comes behind it.
  virtual void follow_scene() {}
  virtual void write(Film& film) = 0;
  virtual void warm_up() = 0;
  virtual std::map<std::string, double> counters() const = 0;
};

}  // namespace lucarium::abuffer
