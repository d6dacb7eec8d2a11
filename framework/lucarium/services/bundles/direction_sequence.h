// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "lucarium/services/bundles/environment_guide.h"

namespace lucarium {

/// One direction of a bundle of parallel rays, which run along `direction` and against it.
struct BundleDirection {
  glm::vec3 direction{0, 0, 1};  ///< unit, ω
  double weight = 0;             ///< W = 1 / (q(ω) + q(-ω)) [sr], q the density of ω over the sphere
  glm::vec2 jitter{0};           ///< of the bundle image's pixel grid, of [0, 1)² (bundle_view.h)
  float rotation = 0;            ///< of the bundle image about ω [turns]
};

/// Which points of the unit square directions are made of.
enum class DirectionOrder {
  iid,         ///< independent
  blocks,      ///< Owen-scrambled Sobol points in blocks, each with a scrambling of its own
  halton,      ///< Halton's sequence in bases 2 and 3, shifted at random
  hammersley,  ///< Hammersley's points in random order, shifted at random
};

struct DirectionOptions {
  DirectionOrder order = DirectionOrder::blocks;
  uint32_t block = 2048;  ///< directions of a block
  uint32_t total = 2000;  ///< N of Hammersley's points; the sequence repeats after them
  double guiding = 0;     ///< share of directions that the guide draws, of [0, 1)
  bool permuted = false;  ///< whole blocks in random order
};

/// The sequence of directions of a run (global ray directions: Hermes et al. 2010, section 4.3, which chooses Halton's
/// sequence over Hammersley's). Any index may be asked for; the same seed gives the same directions.
///
/// Directions are lines: uniform ones cover half of the sphere, so that what is stratified is twice as dense. An
/// estimator that adds W f(ω) for both ends of each line has the mean ∫ f dω over the sphere, guided or not.
///
/// Hammersley's points are shuffled: in natural order they sweep the sphere once, and an average that forgets would
/// hold only the end of the sweep. Blocks are in Sobol's order, in which beginnings are even too, except within runs of
/// 128 directions (the first: 32, 32, 64), which are permuted: Sobol's next directions lie where the last ones did not,
/// which biases what is built on the last few (docs/measurements/bundle_exchange.md, "Directions"). `permuted` is for
/// estimators over pairs of successive directions, which then fill the product space.
class DirectionSequence {
 public:
  /// `guide` may be null: nothing guides, and DirectionOptions::guiding is 0.
  DirectionSequence(const DirectionOptions& options, uint64_t seed,
                    std::shared_ptr<const EnvironmentGuide> guide = nullptr);
  BundleDirection at(uint64_t index) const;
  /// q(ω) [1/sr]; uniform directions count for both of their ends.
  double density(const glm::vec3& direction) const;

 private:
  glm::dvec2 point(uint64_t index) const;
  void make_block(uint64_t block) const;
  DirectionOptions options_;
  uint32_t seed_;
  double guiding_ = 0;
  std::shared_ptr<const EnvironmentGuide> guide_;
  std::vector<uint32_t> order_;  ///< of Hammersley's points
  mutable uint64_t cached_block_ = UINT64_MAX;
  mutable std::vector<glm::dvec2> cached_;  ///< points of that block in the order of use
};

}  // namespace lucarium
