// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/directions/direction_sequence.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "lucarium/base/luminance.h"

namespace lucarium::bundle {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr uint32_t kFirstRun = 32, kRun = 128;  // directions that come in random order

/// PCG RXS-M-XS as in kernels/lucarium/random.clh.
uint32_t hash(uint32_t x) {
  x = x * 747796405u + 2891336453u;
  const uint32_t word = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
  return (word >> 22) ^ word;
}
uint32_t hash(uint32_t a, uint32_t b) { return hash(a + hash(b)); }
uint32_t hash(uint32_t a, uint32_t b, uint32_t c) { return hash(a + hash(b, c)); }
double unit(uint32_t x) { return x * 0x1p-32; }
double fraction(double x) { return x - std::floor(x); }

uint32_t reverse_bits(uint32_t x) {
  uint32_t y = 0;
  for (int i = 0; i < 32; ++i) y |= ((x >> i) & 1u) << (31 - i);
  return y;
}

/// Owen scrambling by Laine and Karras's hash with Vegdahl's constants (kernels/lucarium/sobol.clh).
uint32_t owen_scramble(uint32_t x, uint32_t seed) {
  x = reverse_bits(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reverse_bits(x);
}

/// Second dimension of Sobol's sequence (polynomial x + 1): direction number k+1 is v_k xor v_k >> 1.
uint32_t sobol_second(uint32_t index) {
  uint32_t x = 0;
  for (uint32_t v = 0x80000000u; index; index >>= 1, v ^= v >> 1)
    if (index & 1u) x ^= v;
  return x;
}

double radical_inverse(uint64_t index, uint32_t base) {
  double result = 0, scale = 1.0 / base;
  for (; index; index /= base, scale /= base) result += static_cast<double>(index % base) * scale;
  return result;
}

/// Directions are lines, so that half of the sphere is all there is: what is stratified over it is twice as dense.
glm::vec3 uniform_direction(double u, double v) {
  const double z = 1 - u, r = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * kPi * v;
  return {static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(z)};
}

/// The cell k with c[k] <= x < c[k + 1] and the place in it.
std::pair<uint32_t, double> search(const double* c, uint32_t count, double x) {
  const double* next = std::upper_bound(c + 1, c + count, x);
  const uint32_t k = static_cast<uint32_t>(next - c - 1);
  const double size = c[k + 1] - c[k];
  return {k, size > 0 ? std::clamp((x - c[k]) / size, 0.0, 1.0) : 0.5};
}

/// Fisher and Yates.
template <class T>
void shuffle(std::span<T> values, uint32_t seed) {
  for (uint32_t i = static_cast<uint32_t>(values.size()); i > 1; --i)
    std::swap(values[i - 1], values[static_cast<uint32_t>((uint64_t{hash(seed, i)} * i) >> 32)]);
}

}  // namespace

EnvironmentGuide::EnvironmentGuide(const Environment& environment)
    : width_(environment.width),
      height_(environment.height),
      environment_from_world_(environment.environment_from_world) {
  rows_.assign(height_ + 1, 0.0);
  columns_.assign(size_t{height_} * (width_ + 1), 0.0);
  for (uint32_t j = 0; j < height_; ++j) {
    double* row = &columns_[size_t{j} * (width_ + 1)];
    for (uint32_t i = 0; i < width_; ++i) {
      const glm::vec3 c = environment.radiance[size_t{j} * width_ + i] * environment.factor;
      row[i + 1] = row[i] + std::max(0.0, luminance<double>(c.x, c.y, c.z));
    }
    const double solid_angle = std::cos(kPi * j / height_) - std::cos(kPi * (j + 1) / height_);
    rows_[j + 1] = rows_[j] + row[width_] * solid_angle;
    for (uint32_t i = 1; i <= width_; ++i) row[i] = row[width_] > 0 ? row[i] / row[width_] : double(i) / width_;
  }
  const double total = rows_[height_];
  for (uint32_t j = 1; j <= height_; ++j)
    rows_[j] = total > 0 ? rows_[j] / total : 0.5 - 0.5 * std::cos(kPi * j / height_);
}

glm::vec3 EnvironmentGuide::sample(double u, double v) const {
  const auto [j, y] = search(rows_.data(), height_, v);
  const auto [i, x] = search(&columns_[size_t{j} * (width_ + 1)], width_, u);
  const double top = std::cos(kPi * j / height_), bottom = std::cos(kPi * (j + 1) / height_);
  const double cos_theta = top + y * (bottom - top), sin_theta = std::sqrt(std::max(0.0, 1 - cos_theta * cos_theta));
  const double phi = 2 * kPi * ((i + x) / width_ - 0.5);
  const glm::vec3 local(static_cast<float>(sin_theta * std::cos(phi)), static_cast<float>(cos_theta),
                        static_cast<float>(sin_theta * std::sin(phi)));
  return glm::transpose(environment_from_world_) * local;
}

double EnvironmentGuide::density(const glm::vec3& direction) const {
  const glm::vec3 local = environment_from_world_ * direction;
  const double u = 0.5 + std::atan2(local.z, local.x) / (2 * kPi);
  const double v = std::acos(std::clamp(double{local.y}, -1.0, 1.0)) / kPi;
  const uint32_t i = std::min(static_cast<uint32_t>(u * width_), width_ - 1);
  const uint32_t j = std::min(static_cast<uint32_t>(v * height_), height_ - 1);
  const double* row = &columns_[size_t{j} * (width_ + 1)];
  const double band = 2 * kPi * (std::cos(kPi * j / height_) - std::cos(kPi * (j + 1) / height_));
  return (rows_[j + 1] - rows_[j]) * (row[i + 1] - row[i]) * width_ / band;
}

std::shared_ptr<const EnvironmentGuide> make_guide(const Parameters& parameters, const Environment* environment) {
  // A constant environment guides as the uniform share does.
  if (!environment || environment->width == 0 || parameters.env_guiding <= 0) return nullptr;
  return std::make_shared<EnvironmentGuide>(*environment);
}

DirectionSequence::DirectionSequence(const Parameters& parameters, uint64_t seed,
                                     std::shared_ptr<const EnvironmentGuide> guide, bool permuted)
    : kind_(parameters.sequence),
      block_size_(static_cast<uint32_t>(parameters.block)),
      total_(static_cast<uint32_t>(parameters.directions)),
      seed_(hash(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32), 0x62756e64u)),
      permuted_(permuted),
      guiding_(guide ? static_cast<double>(parameters.env_guiding) : 0.0),
      guide_(std::move(guide)) {
  if (kind_ == Sequence::hammersley) {
    order_.resize(total_);
    std::iota(order_.begin(), order_.end(), 0u);
    shuffle(std::span(order_), hash(seed_, 12));
  }
}

void DirectionSequence::make_block(uint64_t block) const {
  if (cached_block_ == block) return;
  const uint32_t block_seed = hash(seed_, static_cast<uint32_t>(block), 1);
  const uint32_t seed_x = hash(block_seed, 2), seed_y = hash(block_seed, 3);
  cached_.resize(block_size_);
  for (uint32_t i = 0; i < block_size_; ++i)
    cached_[i] = {unit(owen_scramble(reverse_bits(i), seed_x)), unit(owen_scramble(sobol_second(i), seed_y))};
  const std::span all(cached_);
  for (uint32_t first = 0, run = block_size_; first < block_size_; first += run) {
    if (!permuted_) run = block > 0 ? kRun : std::clamp(first, kFirstRun, kRun);
    run = std::min(run, block_size_ - first);
    shuffle(all.subspan(first, run), hash(block_seed, 4, first));
  }
  cached_block_ = block;
}

glm::dvec2 DirectionSequence::point(uint64_t index) const {
  const uint32_t low = static_cast<uint32_t>(index);
  const glm::dvec2 shift(unit(hash(seed_, 5)), unit(hash(seed_, 6)));
  switch (kind_) {
    case Sequence::iid: return {unit(hash(seed_, low, 7)), unit(hash(seed_, low, 8))};
    case Sequence::blocks: make_block(index / block_size_); return cached_[index % block_size_];
    case Sequence::halton:
      return {fraction(radical_inverse(index + 1, 2) + shift.x), fraction(radical_inverse(index + 1, 3) + shift.y)};
    default: {
      const uint64_t i = order_[index % total_];
      return {fraction((static_cast<double>(i) + 0.5) / total_ + shift.x), fraction(radical_inverse(i, 2) + shift.y)};
    }
  }
}

double DirectionSequence::density(const glm::vec3& direction) const {
  const double uniform = (1 - guiding_) / (4 * kPi);  // of ω and -ω in the mean
  return guide_ ? uniform + guiding_ * guide_->density(direction) : uniform;
}

Direction DirectionSequence::at(uint64_t index) const {
  const glm::dvec2 x = point(index);
  const uint32_t low = static_cast<uint32_t>(index);
  Direction result;
  if (x.x < guiding_)
    result.direction = guide_->sample(x.x / guiding_, x.y);
  else
    result.direction = uniform_direction((x.x - guiding_) / (1 - guiding_), x.y);
  result.weight = 1 / (density(result.direction) + density(-result.direction));
  result.jitter = {static_cast<float>(unit(hash(seed_, low, 9) & ~0xffu)),
                   static_cast<float>(unit(hash(seed_, low, 10) & ~0xffu))};
  result.rotation = static_cast<float>(unit(hash(seed_, low, 11) & ~0xffu));
  return result;
}

}  // namespace lucarium::bundle
