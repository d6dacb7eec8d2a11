// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/bundles/kept_bundles.h"

#include <algorithm>

namespace lucarium::bidirectional {

namespace {

constexpr size_t kKeptBytes = size_t{512} << 20;
constexpr size_t kSurfaces = 4;      // behind each other, for which there is memory
constexpr size_t kCopyItems = 4096;  // work-items of a copy

size_t pixels_of(const Plan& plan) { return size_t{plan.bundle_res} * plan.bundle_res; }

size_t bytes_of_entry(const Plan& plan) {
  return (pixels_of(plan) + 1) * sizeof(uint32_t) + kSurfaces * pixels_of(plan) * sizeof(LayeredFragment);
}

/// Bundles for which there is memory.
size_t entries_of(const Plan& plan) {
  return std::min<size_t>(plan.settings.bundles, kKeptBytes / bytes_of_entry(plan));
}

}  // namespace

KeptBundles::KeptBundles(Device& device, const Plan& plan, const std::string& owner)
    : pixels_(static_cast<uint32_t>(pixels_of(plan))),
      entries_(static_cast<uint32_t>(entries_of(plan))),
      capacity_(static_cast<uint32_t>(entries_of(plan) * kSurfaces * pixels_of(plan))),
      starts_(device, owner, "first fragments of kept bundles", size_t{entries_} * (pixels_ + 1),
              "lower bundles or bundle_res, or set another reuse"),
      fragments_(device, owner, "kept bundles", capacity_, "lower bundles or bundle_res, or set another reuse"),
      places_(plan.settings.bundles) {}

void KeptBundles::record_keep(ScheduleRecorder& recorder, const Program& program, const LayeredRaster::Stored& stored,
                              const Variable<uint32_t>& entry, const Variable<uint32_t>& first) const {
  recorder.pass("bundles.keep", program, "keep_bundle")
      .global(kCopyItems)
      .arg("pixels", pixels_)
      .arg("entries", entries_)
      .arg("capacity", capacity_)
      .arg("slot", entry)
      .arg("first", first)
      .arg("pixel_start", stored.pixel_start)
      .arg("fragments", stored.fragments)
      .arg("kept_starts", starts_)
      .arg("kept_fragments", fragments_);
}

void KeptBundles::clear() {
  std::fill(places_.begin(), places_.end(), std::nullopt);
  next_ = {};
}

void KeptBundles::stored(uint32_t k, uint32_t fragments) {
  // As the kernel decides.
  if (next_.entry >= entries_ || fragments > capacity_ - next_.first) return;
  places_[k] = next_;
  ++next_.entry;
  next_.first += fragments;
}

size_t KeptBundles::estimate_bytes(const Plan& plan) { return entries_of(plan) * bytes_of_entry(plan); }

}  // namespace lucarium::bidirectional
