// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/senders/side_preview.h"

#include "bundle_exchange/base/name.h"
#include "lucarium/compute/device/remedies.h"

namespace lucarium::bundle {
namespace {

constexpr size_t kSlice = 1 << 18;  // texel sides between two looks whether to stop, less than 0.1 s
constexpr uint32_t kLevels = 4;     // even: the last one ends in the first buffers. 31 cells across

}  // namespace

SidePreview::SidePreview(Device& device, KernelScheduler& scheduler, const Program& program, const SurfaceAtlas& atlas,
                         const SideMeans& means)
    : scheduler_(&scheduler), means_(&means) {
  const uint32_t sides = means.halves().count;
  for (int k = 0; k < 2; ++k) {
    indirect_[k] = TypedBuffer<float4>(device, technique_name, "smoothed texel sides", sides, remedies::lower_texels);
    direct_[k] = TypedBuffer<float4>(device, technique_name, "smoothed direct light",
                                     means.channels().exchanged() ? sides : 1, remedies::lower_texels);
    variance_[k] =
        TypedBuffer<float>(device, technique_name, "variance of smoothed texel sides", sides, remedies::lower_texels);
  }
  ScheduleRecorder recorder = scheduler.record("smooth texel sides", technique_name);
  correction_ = recorder.variable("correction", 0.f);
  recorder.pass("errors to smooth", program, "begin_preview")
      .global(sides)
      .arg("sides", sides)
      .arg("correction", correction_)
      .arg("shown", means.shown())
      .arg("shown_direct", means.shown_direct())
      .arg("statistics", means.statistics())
      .arg("indirect", indirect_[0])
      .arg("direct", direct_[0])
      .arg("variance", variance_[0]);
  for (uint32_t level = 0; level < kLevels; ++level) {
    const uint32_t from = level % 2, to = 1 - from;
    PassBuilder pass = recorder.pass("smooth texel sides " + std::to_string(1u << level), program, "smooth_preview");
    atlas.bind(pass);
    pass.global(sides)
        .slice(kSlice)
        .arg("sides", sides)
        .arg("stride", 1u << level)
        .arg("indirect", indirect_[from])
        .arg("direct", direct_[from])
        .arg("variance", variance_[from])
        .arg("next_indirect", indirect_[to])
        .arg("next_direct", direct_[to])
        .arg("next_variance", variance_[to]);
  }
  schedule_ = recorder.compile();
}

size_t SidePreview::estimate_bytes(size_t sides, const Channels& channels) {
  return 2 * sides * (sizeof(float4) * (channels.exchanged() ? 2 : 1) + sizeof(float));
}

bool SidePreview::smooth() {
  // One batch gives no estimate of its error: nothing is smoothed then.
  const double n = static_cast<double>(means_->batches());
  schedule_.set(correction_, static_cast<float>(n > 1 ? n / (n - 1) : 0));
  return scheduler_->run(schedule_) == RunResult::done;
}

void SidePreview::warm_up() { scheduler_->warm_up(schedule_); }

}  // namespace lucarium::bundle
