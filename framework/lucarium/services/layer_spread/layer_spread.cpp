// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layer_spread/layer_spread.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lucarium/compute/program/source_library.h"

namespace lucarium {
namespace {

constexpr uint32_t kRun = 512;  // pixels that one work-item sums

}  // namespace

LayerSpread::LayerSpread(Device& device, KernelScheduler& scheduler, const Shown& shown,
                         const TypedBuffer<float>& deviations, const std::string& owner)
    : scheduler_(&scheduler) {
  const auto pixels = static_cast<uint32_t>(deviations.count());
  const Program program(device, SourceLibrary(),
                        {"services/layer_spread", {"lucarium/services/layer_spread/sum_spread.cl"}, {}});
  ScheduleRecorder recorder = scheduler.record("spread of samples", owner);
  const uint32_t runs = (pixels + kRun - 1) / kRun;
  const BufferRef sums = recorder.transient<float4>("sums of spread", runs);
  least_ = recorder.variable("least", 0.f);
  recorder.pass("sum spread", program, "sum_spread")
      .global(runs)
      .local(1)
      .arg("pixels", pixels)
      .arg("run", kRun)
      .arg("least", least_)
      .arg("deviations", deviations)
      .arg("emission", shown.emission)
      .arg("direct", shown.direct)
      .arg("indirect", shown.indirect)
      .arg("has_sky", shown.sky.count() > 0 ? 1u : 0u)
      .arg("sky", shown.sky.count() > 0 ? shown.sky : shown.indirect)
      .arg("sums", sums);
  recorder.read_back("spread", sums, [this](std::span<const std::byte> bytes) { take(bytes); });
  schedule_ = recorder.compile();
}

void LayerSpread::measure() {
  schedule_.set(least_, static_cast<float>(0.01 * luminance_ * luminance_));
  scheduler_->run_to_end(schedule_);
}

void LayerSpread::take(std::span<const std::byte> bytes) {
  double deviations = 0, indirect = 0, luminance = 0, pixels = 0;
  for (size_t offset = 0; offset + sizeof(float4) <= bytes.size(); offset += sizeof(float4)) {
    float4 sum;
    std::memcpy(&sum, bytes.data() + offset, sizeof sum);
    deviations += static_cast<double>(sum.x);
    indirect += static_cast<double>(sum.y);
    luminance += static_cast<double>(sum.z);
    pixels += static_cast<double>(sum.w);
  }
  // The first sample has no luminance to be weighted by, and nothing that it deviates from.
  const bool first = samples_++ == 0;
  if (!(pixels > 0) || !std::isfinite(deviations + indirect + luminance)) return;
  if (!first) {
    sum_ += deviations / pixels;
    ++known_;
  }
  indirect_share_ = indirect / pixels;
  luminance_ = luminance / pixels;
}

void LayerSpread::clear() {
  samples_ = known_ = 0;
  sum_ = luminance_ = indirect_share_ = 0;
}

double samples_for_each(double cheap_variance, double cheap_work, double dear_variance, double dear_work,
                        double largest) {
  if (!(cheap_variance > 0)) return 0;
  if (!(dear_variance > 0)) return largest;
  return std::min(largest, std::sqrt(cheap_variance * dear_work / (cheap_work * dear_variance)));
}

double share_of_work(double variance, double work, double other_variance, double other_work) {
  const double own = std::sqrt(variance * work), other = std::sqrt(other_variance * other_work);
  return own > 0 && std::isfinite(own + other) ? own / (own + other) : 0;
}

}  // namespace lucarium
