// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

struct ImportOptions {
  int gltf_scene = none;                 ///< none: the file's default, else the first
  uint32_t max_texture_size = 8192;      ///< larger images are halved until they fit, with a warning
  uint64_t max_image_pixels = 1u << 28;  ///< larger ones are refused before decoding
  uint64_t max_triangles = 200'000'000;
};

/// Reads .gltf or .glb. Loads completely or throws Error{input} with one line: file, what, where.
Scene import_gltf(const std::filesystem::path& file, const ImportOptions& options = {});
/// The same from memory (fuzzing, embedded files); external URIs are resolved against `folder`.
Scene import_gltf_bytes(std::string_view bytes, const std::filesystem::path& folder, const std::string& shown_name,
                        const ImportOptions& options = {});

/// Equirectangular .hdr or .exr.
Environment load_environment(const std::filesystem::path& file, const ImportOptions& options = {});

/// "cornell", "atrium", … without the "builtin:" prefix.
std::vector<std::string> builtin_scene_names();
Scene make_builtin_scene(const std::string& name);

/// What a user says about a scene on the command line or in the JSON file beside it (docs/scenes.md has the schema).
struct SceneOverrides {
  std::optional<std::string> camera;  ///< NAME | INDEX | "ex,ey,ez:tx,ty,tz[:vfov_degrees]"
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

/// A camera that sees all of `bounds` from an elevated three-quarter view.
SceneCamera frame_camera(const Bounds& bounds, float aspect);

}  // namespace lucarium
