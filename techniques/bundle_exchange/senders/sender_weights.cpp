// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/senders/sender_weights.h"

#include <algorithm>
#include <cmath>

namespace lucarium::bundle {
namespace {

constexpr double kMaxLogGrowth =
    30;  // e^30 of the first weight; single precision goes to e^88, and sums of light need the rest

double growth(double log_growth, double gamma, uint64_t batch) {
  return batch == 1 ? 0.0 : log_growth - std::log1p(-gamma);
}

}  // namespace

SenderWeights::SenderWeights(const Parameters& parameters)
    : plain_(parameters.interleave != Interleave::sd),
      step_exponent_(parameters.step_exponent),
      average_exponent_(parameters.average_exponent) {}

SenderWeights::Step SenderWeights::next(uint64_t first, uint32_t count) const {
  Step step;
  if (plain_) return step;
  double power_sum = 0;
  for (uint32_t i = 0; i < count; ++i) power_sum += std::pow(static_cast<double>(first + i + 1), average_exponent_);
  step.display_weight = power_sum / count;
  const uint64_t k = batch_ + 1;
  const double gamma = std::pow(static_cast<double>(k), -step_exponent_);
  const double log_growth = growth(log_growth_, gamma, k);
  if (log_growth > kMaxLogGrowth) {
    step.sender_scale = std::exp(-log_growth);
    step.sender_weight = gamma;
  } else {
    step.sender_weight = gamma * std::exp(log_growth);
  }
  return step;
}

void SenderWeights::advance() {
  ++batch_;
  const double gamma = std::pow(static_cast<double>(batch_), -step_exponent_);
  log_growth_ = growth(log_growth_, gamma, batch_);
  if (log_growth_ > kMaxLogGrowth) log_growth_ = 0;
}

double SenderWeights::forget(uint64_t batches) {
  const uint64_t before = batch_;
  batch_ = std::min(batch_, batches);
  // Growing weights say by themselves how much of S a batch is; plain ones do not.
  return plain_ && before > 0 ? static_cast<double>(batch_) / static_cast<double>(before) : 1.0;
}

}  // namespace lucarium::bundle
