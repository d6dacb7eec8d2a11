// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/tree/scene_forest.h"

#include <algorithm>

#include "lucarium/base/log.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium::micro {
namespace {

/// Above this share of points on fine details indirect light was seen to err by more than the declared bias.
constexpr double kMaxFineDetails = 0.06;

bool holds(const std::vector<int>& list, int value) { return std::find(list.begin(), list.end(), value) != list.end(); }

}  // namespace

ForestOptions forest_options(const MicroParameters& parameters) {
  ForestOptions options;
  options.points_log2 = parameters.points_log2;
  options.disc_scale = parameters.disc_scale;
  options.all_cullable = parameters.backface == Backface::cull;
  options.skip_hidden = parameters.skip_hidden;
  return options;
}

SceneForest::SceneForest(const TechniqueContext& context, const MicroParameters& parameters, const std::string& owner)
    : context_(context), options_(forest_options(parameters)), owner_(owner) {
  options_.progress = context.progress;
}

bool SceneForest::follow(const SceneChange& change) {
  const bool rebuild = !forest_ || !forest_->update(change);
  if (change.topology) moved_.clear(), options_.moving.clear();  // instances may have other numbers
  if (!rebuild) return true;
  options_.posed = !change.topology && (options_.posed || (forest_ && forest_->loosened()));
  // What a program moves once gives the picture of a fresh start. What it moves again gets a tree of its own, so that
  // the next move is one of its matrix.
  for (const int instance : change.moved_instances) {
    std::vector<int>& list = holds(moved_, instance) ? options_.moving : moved_;
    if (!holds(list, instance)) list.push_back(instance);
  }
  return false;
}

void SceneForest::make() {
  for (bool again = true; again;) {
    forest_.reset();
    options_.intersector = &context_.bvh();
    forest_ = std::make_unique<PointForest>(*context_.device, context_.scheduler, context_.scene,
                                            context_.scene_buffers, options_, owner_);
    again = !options_.posed && forest_->loosened();
    options_.posed = options_.posed || again;
  }
}

void SceneForest::warn_of_details() const {
  if (!forest_ || forest_->fine_details() <= kMaxFineDetails) return;
  log_warning(
      "micro_rendering: {:.0f} % of the points are on details finer than their discs: indirect light may be off by "
      "several "
      "per cent; raise points_log2, or compare with a reference",
      100 * forest_->fine_details());
}

}  // namespace lucarium::micro
