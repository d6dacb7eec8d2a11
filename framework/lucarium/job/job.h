// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "lucarium/compute/device/device.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/walk.h"

namespace lucarium {

/// A picture of one technique: what `lucarium render` makes.
struct RenderWork {
  std::string technique;
  std::vector<std::pair<std::string, std::string>> parameters;
  double seconds = 0;               ///< of preparing and iterating; 0: no limit
  uint64_t iterations = 0;          ///< 0: no limit
  double relmse = 0;                ///< stop when the error against `reference` is at most this; 0: do not
  std::filesystem::path reference;  ///< to measure the error against; empty: it is not measured
  bool curve = false;               ///< measure it while rendering, too
  std::filesystem::path output;     ///< .exr, replaced if it is there; empty: none
  uint64_t samples = 0;             ///< per pixel; 0: no limit
  uint64_t work_iterations = 0;  ///< those before the technique knows how much work there is not counted; 0: no limit
  Walk walk;                     ///< behind it
};

/// A reference image, rendered or extended: what `lucarium reference` makes.
struct ReferenceWork {
  std::string path_set;          ///< PathSet::to_string()
  uint64_t samples = 0;          ///< per pixel; 0: no limit
  double relmse = 0;             ///< its own; 0: no limit
  std::filesystem::path output;  ///< .exr; extended if it is there
  uint64_t round_samples = 0;    ///< positive: one round of so many samples per pixel, with the job's seed, alone
};

/// One rendering for a process of its own, which prints its summary as JSON. Relative paths are those of the working
/// directory. Of `import` the texture size alone goes along; the rest are the program's limits.
struct Job {
  std::string scene;  ///< file or builtin:NAME
  SceneOverrides overrides;
  ImportOptions import;
  uint32_t width = 640, height = 360;
  int max_bounces = -1;
  uint32_t pixel_sampling = 0;
  uint64_t seed = 1;
  DeviceOptions device;
  std::vector<std::filesystem::path> technique_folders;  ///< searched before all others
  bool verbose = false;                                  ///< say on standard error what is being done
  std::variant<RenderWork, ReferenceWork> work;
};

}  // namespace lucarium
