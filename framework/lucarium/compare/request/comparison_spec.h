// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/load_scene.h"

namespace lucarium {

/// A technique with parameter values; the label identifies it in tables ("path_tracing:estimator=bsdf").
struct TechniqueVariant {
  std::string technique;
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string name;  ///< label of the user's choice; empty: made from the others
  std::string label() const { return name.empty() ? words() : name; }
  std::string words() const;  ///< as after -t on the command line
};

/// How long each run lasts: exactly one of seconds, iterations, samples and relmse is positive.
struct ComparisonBudget {
  double seconds = 0;         ///< equal time: of preparing (upload, BVH, prepare) and iterating
  uint64_t iterations = 0;    ///< equal iterations
  double relmse = 0;          ///< equal error: until a snapshot's relMSE is at most this …
  double limit_seconds = 0;   ///< … or this time is over
  uint64_t samples = 0;       ///< equal samples per pixel
  std::string label() const;  ///< "2.5 s", "64 iterations", "16 spp", "relMSE 0.001"
};

/// A scene and the changes to it.
struct ComparisonScene {
  std::string source;  ///< file or builtin:NAME
  SceneOverrides overrides;
  ImportOptions import;
  std::string name;       ///< in tables; empty: the source
  bool optional = false;  ///< left out where there is no such file
  // In place of the comparison's, where given: what a cost depends on can vary from scene to scene.
  std::optional<std::pair<uint32_t, uint32_t>> size;
  std::optional<int> max_bounces;
  int threads = 0;  ///< of the device; 0: not given
  const std::string& label() const { return name.empty() ? source : name; }
};

struct ReferenceRequest {
  std::optional<std::filesystem::path> file;  ///< an image to compare with instead of rendering; then one scene only
  uint64_t samples = 4096;                    ///< per pixel
  double relmse = 0;                          ///< its own; when positive it decides, and `samples` is the most
};

/// A walk along each scene's camera path behind every picture.
struct WalkRequest {
  uint32_t frames = 0;      ///< at least 2
  uint32_t samples = 1;     ///< per pixel and frame
  uint32_t references = 0;  ///< frames, evenly, that have one
};

/// With what the pictures of one scene are rendered: what it says of its own, else what the comparison says.
struct SceneSettings {
  uint32_t width = 0, height = 0;
  int max_bounces = -1;
  std::vector<std::string> device_arguments;  ///< words; read_device_arguments() understands them
};

/// Everything that defines a comparison: scenes × variants × budgets × seeds against references (docs/comparisons.md).
struct ComparisonSpec {
  std::vector<ComparisonScene> scenes;
  std::vector<TechniqueVariant> variants;
  std::vector<ComparisonBudget> budgets;
  uint32_t seeds = 3;  ///< independent runs of each variant
  uint32_t width = 640, height = 360;
  int max_bounces = -1;
  uint32_t pixel_sampling = 0;
  ReferenceRequest reference;
  std::optional<WalkRequest> walk;
  std::string fallback_environment;           ///< for scenes without any light; empty: such a scene is an error
  std::vector<std::string> device_arguments;  ///< words; read_device_arguments() understands them

  SceneSettings settings_of(const ComparisonScene& scene) const;

  /// JSON (schema lucarium-comparison-1) that is kept with the results; parse_comparison() is its inverse.
  std::string to_json() const;
};

/// Reads a comparison file. Throws Error{usage} naming file, line and key.
ComparisonSpec read_comparison(const std::filesystem::path& file);

/// Fault in a sky for scenes without light; empty if there is none.
std::string fallback_mistake(const std::string& environment);

/// Throws Error{usage} if the specification is invalid, whether it comes from a file or the command line.
void check_comparison(const ComparisonSpec& spec);

}  // namespace lucarium
