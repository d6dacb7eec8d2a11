// SPDX-License-Identifier: Apache-2.0
// The frame of a rendering as kernels take it. Declared in technique.h.
#include "lucarium/technique/technique.h"

namespace lucarium {

Frame make_frame(const RenderSettings& settings) {
  Frame frame{};
  frame.camera = make_camera(settings.camera, static_cast<float>(settings.width) / static_cast<float>(settings.height));
  frame.width = settings.width;
  frame.height = settings.height;
  frame.pixel_sampling = settings.pixel_sampling;
  frame.seed = kernel_seed(settings.seed);
  frame.max_bounces = settings.max_bounces;
  return frame;
}

}  // namespace lucarium
