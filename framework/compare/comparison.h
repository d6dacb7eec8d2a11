// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/compute/scheduler.h"
#include "lucarium/scene/load_scene.h"
#include "lucarium/technique/path_set.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

/// A technique with parameter values; the label identifies it in tables ("path_tracing:estimator=bsdf").
struct TechniqueVariant {
  std::string technique;
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string label() const;
};

/// Everything that defines a comparison: scenes × variants × seeds at one budget, against a reference.
struct ComparisonSpec {
  std::vector<std::string> scenes;  ///< files or builtin:NAME
  std::vector<TechniqueVariant> variants;
  Budget budget;       ///< exactly one of seconds (equal time) and iterations (equal iterations)
  uint32_t seeds = 3;  ///< independent runs of each variant
  uint32_t width = 640, height = 360;
  int max_bounces = -1;
  uint32_t pixel_sampling = 0;
  uint32_t reference_samples = 4096;               ///< per pixel, when the reference is rendered
  std::optional<std::filesystem::path> reference;  ///< an image to compare with instead; then one scene only
  std::string fallback_environment;          ///< for scenes without any light; empty: such a scene is an error
  std::optional<float> exposure;             ///< [stops] of all pictures; empty: the scene's
  std::vector<std::string> scene_arguments;  ///< overrides passed to every piece as written (--camera X …)
  std::vector<std::string> device_arguments; ///< --device X, --threads N, …
  SceneOverrides overrides;                  ///< the same overrides, for this process; not part of the JSON

  /// JSON that is kept with the results; parse() is its inverse and names unknown keys.
  std::string to_json() const;
  static ComparisonSpec parse(const std::string& json, const std::string& shown_name);
};

/// One run of one variant on one scene with one seed.
struct PieceResult {
  size_t scene = 0, variant = 0;
  uint32_t seed = 1;
  std::string image;           ///< file name below the result folder, empty when it failed
  std::string failure;         ///< why there is no image
  std::string render_summary;  ///< JSON that `lucarium render --json` printed
  double seconds = 0;          ///< of iterating
  double prepare_seconds = 0;  ///< upload, BVH, prepare: scene-dependent, apart from iterating
  double compile_seconds = 0;  ///< kernel compilation and warm-up: not counted
  uint64_t samples = 0;
  double rmse = 0, relmse = 0;  ///< against the reference, image sum
  size_t peak_memory_bytes = 0;
};

/// The reference of one scene.
struct ReferenceResult {
  std::string image;   ///< below the result folder
  std::string source;  ///< "path_tracing, 4096 samples per pixel", or the given file
  std::string path_set;
  bool from_cache = false;
  double seconds = 0;
  bool error_known = false;    ///< false for an image given as a file
  double mse = 0, relmse = 0;  ///< its own error, estimated from independent replicates
};

/// One scene of the comparison with what is to be said about it.
struct SceneResult {
  std::string name;  ///< as given
  uint64_t triangles = 0;
  std::string hash;
  float exposure = 0;  ///< [stops]
  ReferenceResult reference;
  std::string failure;  ///< the scene or its reference could not be had
  std::vector<std::string> warnings;
  std::vector<std::vector<std::string>> limitations;  ///< per variant
};

struct ComparisonResult {
  ComparisonSpec spec;
  std::vector<SceneResult> scenes;
  std::vector<PieceResult> pieces;
  std::string device, driver, version;
  bool interrupted = false;

  std::string to_json() const;  ///< results.json (docs/results.md)
  std::string to_csv() const;
  static ComparisonResult parse(const std::string& json, const std::string& shown_name);
};

struct ComparisonOptions {
  std::filesystem::path folder;   ///< of the results; created
  bool resume = false;            ///< continue what is there
  bool overwrite = false;         ///< replace what is there
  std::filesystem::path program;  ///< the lucarium executable that renders the pieces
  std::filesystem::path cache_dir;
  std::function<void(const std::string&)> progress;  ///< one line for people
};

/// Runs what is missing, writes results.json, results.csv and report.html as pieces come, and returns the results. Each
/// piece runs in a process of its own. On Ctrl-C the finished pieces stay and `interrupted` is set.
ComparisonResult run_comparison(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                const ComparisonOptions& options);

/// Writes report.html for results in `folder` (docs/report.md).
void write_report(const ComparisonResult& result, const std::filesystem::path& folder);

}  // namespace lucarium
