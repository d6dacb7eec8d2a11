// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/walk.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/session/session.h"

namespace lucarium {

CameraKey walk_camera(const CameraPath& path, uint32_t frame, uint32_t frames) {
  const double first = path.keys.front().seconds, last = path.keys.back().seconds;
  return sample_camera_path(path, first + (last - first) * frame / std::max(1u, frames - 1));
}

std::vector<uint32_t> walk_reference_frames(uint32_t frames, uint32_t count) {
  count = std::min(count, frames);
  std::vector<uint32_t> chosen;
  for (uint32_t i = 0; i < count; ++i)
    chosen.push_back(count == 1 ? 0 : static_cast<uint32_t>(uint64_t{i} * (frames - 1) / (count - 1)));
  return chosen;
}

std::vector<double> walk(RenderSession& session, const Walk& request,
                         const std::function<void(uint32_t frame, const std::vector<float>& image)>& on_frame) {
  const std::optional<CameraPath>& path = session.scene().camera_path;
  if (!path)
    throw_error(ErrorClass::input, "{}: there is no camera path to walk along; give camera_path",
                session.scene().source);
  session.hold_light();
  std::vector<double> seconds;
  for (uint32_t frame = 0; frame < request.frames; ++frame) {
    const SceneCamera camera = camera_on_path(*path, walk_camera(*path, frame, request.frames).seconds);
    const Stopwatch watch;
    session.set_camera(camera);
    if (session.run({.samples = request.samples})) break;
    const std::vector<float> image = session.resolve().image();
    seconds.push_back(watch.seconds());
    on_frame(frame, image);
  }
  return seconds;
}

}  // namespace lucarium
