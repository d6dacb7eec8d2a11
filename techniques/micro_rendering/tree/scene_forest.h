// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lucarium/technique/technique.h"
#include "micro_rendering/base/micro_parameters.h"
#include "micro_rendering/tree/point_forest.h"

namespace lucarium::micro {

/// Options of a scene's first forest.
ForestOptions forest_options(const MicroParameters& parameters);

/// The forest of a scene over all its changes. It knows which instances a program moves, and whether leaves must be
/// ordered as they stand.
class SceneForest {
 public:
  /// Has no forest yet. `context` outlives it.
  SceneForest(const TechniqueContext& context, const MicroParameters& parameters, const std::string& owner);

  const PointForest* get() const { return forest_.get(); }
  /// Follows a change; false: call make() again, when nothing refers to it any more.
  bool follow(const SceneChange& change);
  /// Throws Error{interrupted}; there is no forest then.
  void make();
  /// Warns when details are too fine for the points.
  void warn_of_details() const;

 private:
  const TechniqueContext& context_;
  ForestOptions options_;
  std::string owner_;
  std::vector<int>
      moved_;  ///< instances that have been moved though no animation does it; options_.moving: moved again
  std::unique_ptr<PointForest> forest_;
};

}  // namespace lucarium::micro
