// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "lucarium/film/film.h"
#include "lucarium/statistics/image_comparison.h"

namespace lucarium {

/// How far a reference itself may be from the truth, estimated from its two independent halves A and B with a and b
/// samples: MSE = ⟨(A−B)²⟩ · ab/(a+b)², which is ⟨(A−B)²⟩/4 for halves of the same size; relMSE likewise with every
/// pixel's term divided by r² + 0.01 Ȳ² (docs/references.md).
struct ReferenceError {
  double mse = 0;  ///< [(cd/m²)²]
  double relmse = 0;
};

/// A reference image that grows: the mean, by samples, of rounds that were rendered with seeds of their own, of which
/// one half also goes into layer "HalfA" and the other into "HalfB". Layers that are neither radiance nor "Variance"
/// keep the first round's values. Rounds are independent, so the variance of the mean is the sum of n²·Var / (Σn)².
class ReferenceImage {
 public:
  static constexpr size_t halves = 2;

  /// Nothing rendered yet.
  ReferenceImage(uint32_t width, uint32_t height);
  /// What film() gave earlier. Throws Error{input} naming `shown_name` when the film is not a reference.
  ReferenceImage(Film film, const std::string& shown_name);

  /// Adds a round of `samples` samples per pixel to one half. Throws Error{internal} when size or layers differ.
  void add(const Film& round, uint64_t samples, size_t half);

  uint64_t samples() const { return samples_[0] + samples_[1]; }
  uint64_t samples(size_t half) const { return samples_[half]; }
  /// Rounds so far; the next one's seed comes from it.
  uint64_t rounds() const { return rounds_; }
  /// Whether both halves hold samples, so that error() means something.
  bool error_known() const { return samples_[0] > 0 && samples_[1] > 0; }
  ReferenceError error() const;
  /// Whether the halves are the same up to noise (image_test.h); the noise of each is taken from the layer "Variance".
  /// Passes without tests when there is no such layer, or one half only.
  ImageTest test_halves() const;

  /// The image, its layers and halves; metadata `samples`, `half_a_samples`, `half_b_samples`, `rounds`,
  /// `variance_dof`, `round_samples_squared`, `own_mse` and `own_relmse` are up to date, others are the caller's.
  const Film& film();
  std::map<std::string, std::string>& metadata() { return film_.metadata; }

 private:
  Film film_;
  std::array<uint64_t, halves> samples_{};
  double variance_dof() const;

  uint64_t rounds_ = 0;
  double squares_ = 0;    ///< sum over rounds of their samples squared
  double round_dof_ = 0;  ///< degrees of freedom of one round's variance
};

/// Own error of any reference film: by its halves, else by the layer "Variance" of independent replicates; false when
/// it has neither.
bool estimate_reference_error(const Film& film, ReferenceError& error);

}  // namespace lucarium
