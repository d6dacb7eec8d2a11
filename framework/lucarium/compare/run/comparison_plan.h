// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/compare/run/comparison.h"
#include "lucarium/job/job.h"

namespace lucarium {

/// One scene of a comparison, looked at before anything is rendered.
struct ScenePlan {
  SceneResult result;                                ///< all but what the references turn out to be
  SceneOverrides overrides;                          ///< the scene's, with the fallback environment where it is needed
  std::vector<std::string> reference_files;          ///< names in the cache, one per reference
  std::vector<uint32_t> walk_frames;                 ///< that have references
  std::vector<std::string> walk_cameras;             ///< theirs
  std::vector<std::vector<std::string>> walk_files;  ///< theirs in the cache, for each reference
  size_t pieces = 0;                                 ///< variants that are not refused
  bool automatic_exposure = false;                   ///< none is stated: the first reference decides
};

/// Base seed of references: not one of the pieces' seeds 1, 2, …
inline constexpr uint64_t reference_seed = 0x5eed;

/// Sets the variant's parameters; mistakes in them are errors with the technique's name.
void set_parameters(Technique& technique, const TechniqueVariant& variant);

/// Loads the scene, asks every variant which light paths it computes, and groups the variants by that: one reference
/// each. Variants that cannot do the settings are marked as refused. A scene that cannot be used has a failure; throws
/// Error for mistakes in the comparison itself (unknown technique or parameter).
ScenePlan plan_scene(const ComparisonSpec& spec, const ComparisonScene& scene, const TechniqueRegistry& registry);

/// The job of one piece, or of a reference: scene, image and device; its work is not set.
Job scene_job(const ComparisonSpec& spec, const ComparisonScene& scene, const ScenePlan& plan,
              const ComparisonOptions& options, uint64_t seed);

}  // namespace lucarium
