// SPDX-License-Identifier: Apache-2.0
// What a technique does not declare is refused here, before anything is allocated. Declared in session.h.
#include <fmt/ranges.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/session/session.h"

namespace lucarium {

void check_settings(const TechniqueInfo& info, const RenderSettings& settings) {
  const Capabilities& can = info.capabilities;
  if (settings.width == 0 || settings.height == 0 || uint64_t{settings.width} * settings.height > (uint64_t{1} << 28)) {
    throw_error(ErrorClass::usage, "--size {}x{} is not an image size this program renders", settings.width,
                settings.height);
  }
  if (can.max_bounces >= 0 && (settings.max_bounces < 0 || settings.max_bounces > can.max_bounces)) {
    throw_error(ErrorClass::technique, "{} computes at most {} bounces; give --max-bounces {} or fewer", info.name,
                can.max_bounces, can.max_bounces);
  }
  if (std::find(can.pixel_sampling.begin(), can.pixel_sampling.end(), settings.pixel_sampling) ==
      can.pixel_sampling.end()) {
    throw_error(ErrorClass::technique,
                "{} cannot sample pixels in mode {} (0 jitter, 1 center, n grid); it supports {}", info.name,
                settings.pixel_sampling, fmt::join(can.pixel_sampling, ", "));
  }
}

}  // namespace lucarium
