// SPDX-License-Identifier: Apache-2.0
// Options that several commands share; each struct adds itself to a subcommand.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/job/job.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/technique/plugin.h"

namespace lucarium::app {

/// --device, --threads, --cache-dir, --no-cache, --memory-limit
struct DeviceArguments {
  DeviceOptions options;
  bool no_cache = false;
  std::string memory_limit, allocation_limit;
  void add_to(Command command);
  void take(const DeviceOptions& given);  ///< instead of options
  /// With the texts parsed; throws Error{usage}.
  DeviceOptions resolved() const;
  /// As a comparison file states it ("device_arguments"), without what is this machine's.
  std::vector<std::string> in_comparison() const;
  /// What is this machine's: the program, its caches, and where it looks for plug-ins.
  void apply_to(ComparisonOptions& comparison, const std::vector<std::filesystem::path>& technique_folders) const;
};

/// --camera, --environment, --light, --exposure, --material, --at, --animation, --no-sidecar, --texture-size
struct SceneArguments {
  SceneOverrides overrides;
  ImportOptions import;
  bool no_sidecar = false;
  void add_to(Command command);
  void take(const Job& job);  ///< instead of options
  Scene load(const std::string& source) const;
  SceneOverrides resolved() const;
};

/// --size, --max-bounces, --pixel-sampling, --seed
struct ImageArguments {
  std::string size = "640x360";
  std::string pixel_sampling = "jitter";
  int max_bounces = -1;
  uint64_t seed = 1;
  void add_to(Command command, bool with_seed);
  /// Settings without a camera; throws Error{usage}.
  RenderSettings settings() const;
};

/// -t NAME[:key=value,…] and -p key=value, which binds to the -t before it.
struct TechniqueArguments {
  struct Spec {
    std::string name;
    std::vector<std::pair<std::string, std::string>> parameters;
  };
  std::vector<Spec> specs;
  std::vector<std::filesystem::path> folders;  ///< --technique-path
  void add_to(Command command);
  static Spec parse(const std::string& text);
};

/// Sets the parameters on an instance that is thrown away, so that mistakes are found before long work.
void check_parameters(const TechniqueType& type, const TechniqueArguments::Spec& spec);

/// --json, --quiet, -v
struct OutputArguments {
  bool json = false, quiet = false, verbose = false;
  void add_to(Command command, bool with_json = true);
  void apply() const;  ///< sets the log level
};

/// --technique-path: folders that are there, searched before all others.
void add_technique_path(Command command, std::vector<std::filesystem::path>& folders);

/// Settings of a job, without a camera.
RenderSettings settings_of(const Job& job);

/// "1920x1080" → {1920, 1080}.
std::pair<uint32_t, uint32_t> parse_size(const std::string& text);

}  // namespace lucarium::app
