// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "lucarium/compare/request/comparison_spec.h"
#include "lucarium/compare/results/bias.h"
#include "lucarium/compare/results/gate.h"
#include "lucarium/compare/results/machine.h"
#include "lucarium/compare/results/reproduction.h"
#include "lucarium/statistics/statistics.h"

namespace lucarium {

/// State of an error curve.
struct Snapshot {
  double seconds = 0;  ///< of preparing and iterating
  uint64_t iterations = 0, samples = 0;
  std::map<std::string, double> metrics;
  std::optional<double> processor_seconds;  ///< of the same, on a CPU; absent in results of earlier versions
};

/// A walk behind a run, or the walks of all seeds (docs/results.md).
struct WalkTimes {
  double min_seconds = 0, median_seconds = 0, max_seconds = 0;  ///< of a frame
  std::optional<double> relmse;                                 ///< mean over the frames with a reference
};

/// One run: scene, variant, budget (indices) and seed.
struct PieceResult {
  size_t scene = 0, variant = 0, budget = 0;
  uint32_t seed = 1;
  std::string image;           ///< file name below the result folder, empty when it failed
  std::string failure;         ///< why there is no image
  std::string render_summary;  ///< JSON of the frame that `lucarium render --json` printed, with peak_host_bytes
  std::string parameters;      ///< all that were in effect, those planned for the budget too; empty when it failed
  double load_seconds = 0, prepare_seconds = 0, compile_seconds = 0, iterate_seconds = 0, device_seconds = 0;
  uint64_t samples = 0, iterations = 0;
  size_t peak_host_bytes = 0, peak_device_bytes = 0;
  bool converged = false;
  std::map<std::string, double> metrics;  ///< of the image against the scene's reference
  std::vector<Snapshot> snapshots;
  std::optional<double> processor_seconds;                           ///< of preparing and iterating, as in a snapshot
  std::optional<double> reached_seconds, reached_processor_seconds;  ///< with an error budget
  std::optional<WalkTimes> walk;
  std::string device;                   ///< and driver; empty when it failed
  std::optional<PieceMachine> machine;  ///< absent in results of earlier versions
  double seconds() const { return prepare_seconds + iterate_seconds; }
};

/// The truth for one scene and one set of light paths.
struct ReferenceResult {
  std::string path_set;                ///< in its simplest form on this scene
  std::vector<std::string> also_said;  ///< by techniques that compute the same light
  /// Whether a picture that says this of its light paths can be measured against it.
  bool is_for(const std::string& said) const {
    return said == path_set || std::find(also_said.begin(), also_said.end(), said) != also_said.end();
  }
  std::string image;   ///< below the result folder
  std::string source;  ///< "path_tracing", or the given file
  std::string failure;
  uint64_t samples = 0;
  bool from_cache = false;
  double seconds = 0;
  bool error_known = false;    ///< false for an image file without an error estimate
  double mse = 0, relmse = 0;  ///< its own error
  /// The truth for one frame of a walk.
  struct Frame {
    uint32_t frame = 0;
    std::string camera;  ///< as on the command line
    std::string image;   ///< below the result folder
  };
  std::vector<Frame> walk;
};

/// One variant on one scene.
struct SceneVariant {
  size_t reference = 0;                  ///< index into the scene's references
  std::vector<std::string> limitations;  ///< parts of the scene that it cannot compute
  std::string refused;                   ///< why it does not run at all
  size_t device_bytes = 0;               ///< estimate, with scene and BVH
};

struct SceneResult {
  std::string name;
  uint64_t triangles = 0, emissive_triangles = 0;
  std::string hash;
  float exposure = 0;     ///< [stops]
  std::string failure;    ///< the scene could not be had
  bool left_out = false;  ///< no failure of the comparison: it is optional, and there is no such file
  std::vector<std::string> warnings;
  bool unlike_machines = false;  ///< its pieces ran on several kinds: their wall times are not compared
  std::vector<ReferenceResult> references;
  std::vector<SceneVariant> variants;
};

/// Scene, variant and budget (indices): what seeds are averaged over.
using SummaryKey = std::tuple<size_t, size_t, size_t>;

/// When the curve of a variant gets to an error, over its seeds.
struct SummaryTime {
  double relmse = 0;
  std::optional<ConfidenceInterval> seconds;  ///< absent: some seed does not get there
  bool at_most = false;                       ///< the first snapshot of some seed was below it already
};

struct SummaryPoint {
  double seconds = 0;  ///< wall time or processor time
  double samples = 0;
  ConfidenceInterval relmse;
};

/// Summary of the finished pieces of one key (docs/results.md).
struct Summary {
  size_t seeds = 0;
  std::map<std::string, ConfidenceInterval> metrics;
  double iterate_seconds = 0, prepare_seconds = 0, compile_seconds = 0, device_seconds = 0, samples = 0;
  size_t peak_host_bytes = 0, peak_device_bytes = 0;
  double debiased_mse = 0;
  bool resolved = true;
  std::optional<BiasAndVariance> bias;               ///< from two seeds on
  std::vector<SummaryPoint> curve, processor_curve;  ///< over wall time, and over processor time where it is known
  ConfidenceInterval slope;                          ///< of `curve`
  std::optional<double> processor_seconds;
  /// With an error budget, when every seed got there.
  std::optional<ConfidenceInterval> reached_seconds, reached_processor_seconds;
  std::vector<SummaryTime> times, processor_times;  ///< to errors, on the curves
  std::optional<WalkTimes> walk;                    ///< smallest, mean of medians, largest; relMSE: geometric mean
};

/// The ratio of two variants' errors or times, paired by seeds.
struct SummaryPair {
  size_t scene = 0, budget = 0, a = 0, b = 0;
  std::string metric;
  ConfidenceInterval ratio;
  bool different() const { return ratio.seeds > 1 && (ratio.low > 1 || ratio.high < 1); }
};

/// One value then and now, of the same scene, variant and budget (by their labels).
struct BaselineChange {
  size_t scene = 0, variant = 0, budget = 0;
  std::string metric;
  ConfidenceInterval ratio;  ///< now over then: geometric means with Welch's 95 % interval on logarithms
  std::string verdict;       ///< better, worse, same (the interval holds 1), unknown (one seed)
};

struct BaselineComparison {
  std::string folder, version;
  std::vector<BaselineChange> changes;
  std::vector<std::string> missing;  ///< summaries that the baseline does not have

  std::string table(const struct ComparisonResult& result) const;  ///< for people
};

struct VariantInfo {
  std::string summary, citation, version;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< all, before a budget of time lowers any
  std::vector<std::string> given;                               ///< names of those that the comparison sets
};

struct ComparisonResult {
  ComparisonSpec spec;
  std::vector<VariantInfo> variants;
  std::vector<SceneResult> scenes;
  std::vector<PieceResult> pieces;
  std::map<SummaryKey, Summary> summaries;
  std::vector<GateResult> gates;
  std::optional<BaselineComparison> baseline;
  std::optional<Reproduction> reproduction;
  std::string device, driver, version, started;
  Machine machine;
  bool interrupted = false;

  std::string to_json() const;        ///< results.json (docs/results.md)
  std::string pieces_csv() const;     ///< results.csv
  std::string snapshots_csv() const;  ///< curves.csv
};

}  // namespace lucarium
