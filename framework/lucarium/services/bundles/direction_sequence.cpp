// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bundles/direction_sequence.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "lucarium/base/numbers.h"
#include "lucarium/shared/hash.h"
#include "lucarium/shared/radical_inverse.h"
#include "lucarium/shared/sobol_points.h"

namespace lucarium {
namespace {

constexpr uint32_t kStream = 0x62756e64u;       // apart from other uses of the same seed
constexpr uint32_t kFirstRun = 32, kRun = 128;  // directions that come in random order

double unit(uint32_t x) { return x * 0x1p-32; }
double fraction(double x) { return x - std::floor(x); }

/// Directions are lines, so that half of the sphere is all there is: what is stratified over it is twice as dense.
glm::vec3 uniform_direction(double u, double v) {
  const double z = 1 - u, r = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * pi * v;
  return {static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(z)};
}

/// Fisher and Yates.
template <class T>
void shuffle(std::span<T> values, uint32_t seed) {
  for (uint32_t i = static_cast<uint32_t>(values.size()); i > 1; --i)
    std::swap(values[i - 1], values[static_cast<uint32_t>((uint64_t{hash_uint2(seed, i)} * i) >> 32)]);
}

}  // namespace

DirectionSequence::DirectionSequence(const DirectionOptions& options, uint64_t seed,
                                     std::shared_ptr<const EnvironmentGuide> guide)
    : options_(options),
      seed_(hash_uint3(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32), kStream)),
      guiding_(guide ? options.guiding : 0.0),
      guide_(std::move(guide)) {
  if (options_.order == DirectionOrder::hammersley) {
    order_.resize(options_.total);
    std::iota(order_.begin(), order_.end(), 0u);
    shuffle(std::span(order_), hash_uint2(seed_, 12));
  }
}

void DirectionSequence::make_block(uint64_t block) const {
  if (cached_block_ == block) return;
  const uint32_t block_seed = hash_uint3(seed_, static_cast<uint32_t>(block), 1);
  const uint4 seeds{hash_uint2(block_seed, 2), hash_uint2(block_seed, 3), 0, 0};
  cached_.resize(options_.block);
  for (uint32_t i = 0; i < options_.block; ++i) {
    const uint4 point = reverse_bits4(owen_scramble_reversed(sobol_reversed(i), seeds));
    cached_[i] = {unit(point.x), unit(point.y)};
  }
  const std::span all(cached_);
  for (uint32_t first = 0, run = options_.block; first < options_.block; first += run) {
    if (!options_.permuted) run = block > 0 ? kRun : std::clamp(first, kFirstRun, kRun);
    run = std::min(run, options_.block - first);
    shuffle(all.subspan(first, run), hash_uint3(block_seed, 4, first));
  }
  cached_block_ = block;
}

glm::dvec2 DirectionSequence::point(uint64_t index) const {
  const uint32_t low = static_cast<uint32_t>(index);
  const glm::dvec2 shift(unit(hash_uint2(seed_, 5)), unit(hash_uint2(seed_, 6)));
  switch (options_.order) {
    case DirectionOrder::iid: return {unit(hash_uint3(seed_, low, 7)), unit(hash_uint3(seed_, low, 8))};
    case DirectionOrder::blocks: make_block(index / options_.block); return cached_[index % options_.block];
    case DirectionOrder::halton:
      return {fraction(radical_inverse(low + 1, 2) + shift.x), fraction(radical_inverse(low + 1, 3) + shift.y)};
    default: {
      const uint32_t i = order_[index % options_.total];
      return {fraction((i + 0.5) / options_.total + shift.x), fraction(radical_inverse(i, 2) + shift.y)};
    }
  }
}

double DirectionSequence::density(const glm::vec3& direction) const {
  const double uniform = (1 - guiding_) / (4 * pi);  // of ω and -ω in the mean
  return guide_ ? uniform + guiding_ * guide_->density(direction) : uniform;
}

BundleDirection DirectionSequence::at(uint64_t index) const {
  const glm::dvec2 x = point(index);
  const uint32_t low = static_cast<uint32_t>(index);
  BundleDirection result;
  if (x.x < guiding_)
    result.direction = guide_->sample(x.x / guiding_, x.y);
  else
    result.direction = uniform_direction((x.x - guiding_) / (1 - guiding_), x.y);
  result.weight = 1 / (density(result.direction) + density(-result.direction));
  result.jitter = {static_cast<float>(unit(hash_uint3(seed_, low, 9) & ~0xffu)),
                   static_cast<float>(unit(hash_uint3(seed_, low, 10) & ~0xffu))};
  result.rotation = static_cast<float>(unit(hash_uint3(seed_, low, 11) & ~0xffu));
  return result;
}

}  // namespace lucarium
