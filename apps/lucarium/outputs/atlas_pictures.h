// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "options/options.h"

namespace lucarium::app {

/// --atlas, --atlas-view, --atlas-texels, --atlas-edge, --atlas-texcoord1, --size, and those of the device.
struct AtlasArguments {
  DeviceArguments device;
  std::filesystem::path charts, view;
  SurfaceAtlasOptions options;
  std::string size = "640x360";
  void add_to(Command command);
  void check(bool overwrite) const;  ///< of the files' names; throws Error{usage} or Error{input}
};

/// Builds the scene's surface atlas and writes the pictures that were asked for; nothing without any.
std::optional<SurfaceAtlasReport> draw_atlas(const AtlasArguments& arguments, const Scene& scene, bool quiet);

std::string text_of(const SurfaceAtlasReport& report);
/// A scene's report as JSON with the atlas' under "atlas".
std::string with_atlas(const std::string& scene_report, const SurfaceAtlasReport& report);

}  // namespace lucarium::app
