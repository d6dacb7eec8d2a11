// SPDX-License-Identifier: Apache-2.0
// Options that several commands share; each struct adds itself to a subcommand.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grammar/command_line.h"
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
  /// `caches_references`: --cache-dir holds references too, which --no-cache does not concern.
  void add_to(Command command, bool caches_references = false);
  void take(const DeviceOptions& given);  ///< instead of options
  /// For one device, with the texts parsed; throws Error{usage}.
  DeviceOptions resolved() const;
  /// The same without a device where several are named.
  DeviceOptions limits() const;
  /// Those that share the work; none: one does all. Throws Error{usage} for indices that this machine does not have.
  std::vector<std::string> shared() const;
  /// As a comparison file states it ("device_arguments"), without what is this machine's.
  std::vector<std::string> in_comparison() const;
  /// What is this machine's: the program, its caches, and where it looks for plug-ins.
  void apply_to(ComparisonOptions& comparison, const std::vector<std::filesystem::path>& technique_folders) const;
};

/// Names of the options of DeviceArguments.
const std::vector<std::string>& device_option_names();

/// --camera, --camera-path, --environment, --light, --exposure, --material, --at, --animation, --no-sidecar,
/// --texture-size
struct SceneArguments {
  SceneOverrides overrides;
  ImportOptions import;
  bool no_sidecar = false;
  void add_to(Command command);
  void add_exposure_to(Command command);  ///< where there are pictures or metrics
  void take(const Job& job);              ///< instead of options
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

/// -t NAME[:key=value,…], and -p key=value,… for the -t before it.
struct TechniqueArguments {
  using Parameters = std::vector<std::pair<std::string, std::string>>;
  struct Spec {
    std::string name;
    Parameters parameters;
  };
  std::vector<Spec> specs;
  Parameters leading;                          ///< of -p before any -t
  std::vector<std::filesystem::path> folders;  ///< --technique-path
  /// `several`: the command takes more than one.
  void add_to(Command command, const std::string& default_technique, bool several = false);
  /// The one that a command takes; `otherwise` where none is named. Throws Error{usage} for several.
  Spec single(const std::string& command, const std::string& otherwise) const;
  /// All that are named. Throws Error{usage} for parameters of none.
  const std::vector<Spec>& all() const;
  static Spec parse(const std::string& text);
  /// "key=value,key=value".
  static Parameters parse_parameters(const std::string& text);
};

/// An instance with these parameters. Made before long work, it finds mistakes in them.
std::unique_ptr<Technique> make_technique(const TechniqueType& type, const TechniqueArguments::Spec& spec);

/// What `render` and `reference` begin with, from the command line or from a job.
struct RenderingArguments {
  std::string scene;
  DeviceArguments device;
  SceneArguments overrides;
  ImageArguments image;
  RenderSettings settings;  ///< of `image`, or of a job; without a camera
  TechniqueArguments technique;
  void take(const Job& job);  ///< instead of options
  /// The scene, which must have light unless the technique computes none; logs its warnings.
  Scene load(const Technique* technique = nullptr) const;
};

/// --technique-path: folders that are there, searched before all others.
void add_technique_path(Command command, std::vector<std::filesystem::path>& folders);

/// "1920x1080" → {1920, 1080}.
std::pair<uint32_t, uint32_t> parse_size(const std::string& text);

}  // namespace lucarium::app
