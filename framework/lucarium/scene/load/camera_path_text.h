// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "lucarium/base/files/json_file.h"
#include "lucarium/scene/camera_path.h"

namespace lucarium {

struct Scene;

/// "linear:KEY;KEY…" or "spline:KEY;KEY…" with KEY = SECONDS@EX,EY,EZ:TX,TY,TZ[:VFOV]; empty: it is not of that form,
/// but a name or a file. Throws Error{usage}.
std::optional<CameraPath> parse_camera_path(std::string_view text);

/// The inverse.
std::string camera_path_text(const CameraPath& path);

/// The object {"interpolation", "keys"} at `pointer`. Throws Error{input} that names file, line and key.
CameraPath read_camera_path(const JsonFile& file, const nlohmann::json& object, const std::string& pointer);

/// What --camera-path says: the name of a path of the scene, the text of one, or a JSON file that holds one. Empty:
/// "none".
std::optional<CameraPath> find_camera_path(const Scene& scene, const std::string& text);

}  // namespace lucarium
