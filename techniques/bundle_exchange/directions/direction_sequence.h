// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "bundle_exchange/parameters.h"
#include "lucarium/scene/scene.h"

namespace lucarium::bundle {

/// One direction of the exchange: its rays run along `direction` and against it.
struct Direction {
  glm::vec3 direction{0, 0, 1};  ///< unit, ω
  double weight = 0;             ///< W = 1 / (q(ω) + q(-ω)) [sr], q the density of ω over the sphere
  glm::vec2 jitter{0};           ///< of the film's pixel grid, of [0, 1)²
  float rotation = 0;            ///< of the film about ω [turns]
};

/// What the environment adds to the density of directions: by mean luminance of its texels.
class EnvironmentGuide {
 public:
  explicit EnvironmentGuide(const Environment& environment);
  glm::vec3 sample(double u, double v) const;        ///< world direction
  double density(const glm::vec3& direction) const;  ///< [1/sr]

 private:
  uint32_t width_, height_;
  glm::mat3 environment_from_world_;
  std::vector<double> rows_;     ///< height + 1 cumulative values
  std::vector<double> columns_;  ///< height × (width + 1)
};

/// Null where the environment (which may be null) guides nobody: it is constant, or `env_guiding` is 0.
std::shared_ptr<const EnvironmentGuide> make_guide(const Parameters& parameters, const Environment* environment);

/// The sequence of directions of a run. Any index may be asked for; the same seed gives the same directions. `total` is
/// the N of Hammersley's points, which come in random order: their own sweeps the sphere once, and means that forget
/// would know only its end. `guide` (may be null: nothing guides) is drawn from with probability `env_guiding`.
///
/// Blocks are in Sobol's order, in which beginnings are even too, but for runs of 128 directions (the first: 32, 32,
/// 64), which are permuted: what senders know comes mostly from the last few directions, and Sobol's next ones lie
/// where those did not. With two rooms that a slit joins, the dark one was 1.3 % too bright after 1024 directions
/// without permutation. A whole block is `permuted` where slots reflect directions: then pairs of successive ones fill
/// the product space.
class DirectionSequence {
 public:
  DirectionSequence(const Parameters& parameters, uint64_t seed, std::shared_ptr<const EnvironmentGuide> guide,
                    bool permuted = false);
  Direction at(uint64_t index) const;
  /// Density of directions over the sphere, where uniform ones count for both of their ends [1/sr].
  double density(const glm::vec3& direction) const;

 private:
  glm::dvec2 point(uint64_t index) const;
  void make_block(uint64_t block) const;
  Sequence kind_;
  uint32_t block_size_, total_, seed_;
  bool permuted_;
  double guiding_ = 0;
  std::shared_ptr<const EnvironmentGuide> guide_;
  std::vector<uint32_t> order_;  ///< of Hammersley's points
  mutable uint64_t cached_block_ = UINT64_MAX;
  mutable std::vector<glm::dvec2> cached_;  ///< points of that block in the order of use
};

}  // namespace lucarium::bundle
