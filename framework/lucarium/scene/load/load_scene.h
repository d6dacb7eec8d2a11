// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/scene/import_options.h"

namespace lucarium {

/// What a user says about a scene on the command line or in the JSON file beside it (docs/scenes.md has the schema).
struct SceneOverrides {
  std::optional<std::string> camera;       ///< NAME | INDEX | "ex,ey,ez:tx,ty,tz[:vfov_degrees]"
  std::optional<std::string> camera_path;  ///< NAME | FILE | "linear:KEY;KEY…" | "spline:KEY;KEY…" | "none"
  std::optional<std::string>
      environment;  ///< file, or "r,g,b" constant, with optional "*factor" and "@degrees" rotation
  std::vector<std::string>
      lights;  ///< "point:x,y,z:r,g,b", "spot:…", "directional:dx,dy,dz:r,g,b", "none" drops the file's
  std::optional<float> exposure;
  std::optional<double> at_seconds;
  std::optional<std::string> animation;  ///< name or index
  std::vector<std::string> materials;    ///< "NAME:key=value[,key=value]"; NAME may hold * wildcards
  bool use_sidecar = true;               ///< read FILE.lucarium.json when it is there
};

/// Loads a file or builtin:NAME, applies the sidecar, then the overrides, evaluates the time, frames a camera when
/// there is none (with a warning), and validates. The result has at least one camera; the chosen one is first.
Scene load_scene(const std::string& source, const SceneOverrides& overrides = {}, const ImportOptions& options = {});

/// Throws Error{input} that names --environment and --light unless something emits.
void require_light(const Scene& scene);

}  // namespace lucarium
