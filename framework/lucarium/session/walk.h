// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "lucarium/scene/camera_path.h"

namespace lucarium {

class RenderSession;

inline constexpr uint32_t max_walk_frames = 100000;

/// A walk along the camera path of a scene, behind a picture: what light there is then stays as it is.
struct Walk {
  uint32_t frames = 0;   ///< evenly over the path, its ends included; 0: no walk, else at least 2
  uint32_t samples = 1;  ///< per pixel and frame
  /// Frames with a reference, ascending, and its file.
  std::vector<uint32_t> reference_frames;
  std::vector<std::filesystem::path> references;
};

/// Where the camera stands in a frame.
CameraKey walk_camera(const CameraPath& path, uint32_t frame, uint32_t frames);

/// `count` of its frames (at most all), evenly, the first and the last one among them.
std::vector<uint32_t> walk_reference_frames(uint32_t frames, uint32_t count);

/// Holds the light, and renders the frames; `on_frame` gets each picture, outside the time. Returns the wall times [s]
/// from the move of the camera until the picture is on the host: fewer than frames where it was interrupted. Throws
/// Error{input} for a scene without a camera path.
std::vector<double> walk(RenderSession& session, const Walk& request,
                         const std::function<void(uint32_t frame, const std::vector<float>& image)>& on_frame);

}  // namespace lucarium
