// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/guide/guide_photons.h"

#include <cstring>

#include "bidirectional_vpl/base/slices.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

// They are put into order again when there are so many times as many: the cost of all orders stays that of a few.
constexpr double kGrowth = 1.25;
// Photons of narrow lobes that are no accident, and that are a part of the light worth looking at.
constexpr uint32_t kMinNarrow = 64;
constexpr double kNarrowShare = 0.005;
// Light paths before the first sample: until there are so many photons, in so many rounds at most, or until some
// thousand paths have found next to nothing.
constexpr uint32_t kEnough = 4096, kRounds = 16;
constexpr double kPathsToLook = 4096, kPathsToGiveUp = 1 << 20;
constexpr int kKeyBits = 31;  // with BIDIRECTIONAL_GUIDE_NO_KEY

}  // namespace

GuidePhotons::GuidePhotons(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                           const std::string& owner)
    : scheduler_(scheduler),
      owner_(owner),
      primitives_(device),
      program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/guide/collect_photons"}, {})),
      photons_(device, owner, "guiding photons", BIDIRECTIONAL_GUIDE_PHOTONS),
      ordered_(device, owner, "guiding photons in order", BIDIRECTIONAL_GUIDE_PHOTONS),
      keys_(device, owner, "keys of guiding photons", BIDIRECTIONAL_GUIDE_PHOTONS),
      stored_(device, owner, "number of guiding photons", 1),
      ordered_count_(device, owner, "number of guiding photons in order", 1),
      narrow_count_(device, owner, "number of narrow guiding photons", 1) {
  clear();
  record_order(scene);
}

Schedule GuidePhotons::record_collect(const LightVertices& vertices, const Plan& plan) {
  const auto slots = static_cast<uint32_t>(plan.vertex_slots());
  ScheduleRecorder recorder = scheduler_.record("collect guiding photons", owner_);
  const BufferRef present = recorder.transient<uint32_t>("guiding vertices", slots);
  const BufferRef list = recorder.transient<uint32_t>("list of guiding vertices", slots);
  const BufferRef listed = recorder.transient<uint32_t>("number of guiding vertices", 1);
  recorder.pass("mark guiding vertices", program_, "mark_guide_vertices")
      .global(slots)
      .slice(kSlice)
      .arg("vertices", vertices.vertices())
      .arg("count", slots)
      .arg("present", present);
  primitives_.record_compact(recorder, "list guiding vertices", present, list, listed, 0, vertices.slot_count(), 0,
                             slots);
  recorder.pass("take guiding photons", program_, "take_guide_photons")
      .global(slots)
      .slice(kSlice)
      .arg("vertices", vertices.vertices())
      .arg("list", list)
      .arg("listed", listed)
      .arg("stored", stored_)
      .arg("photons", photons_);
  recorder.pass("count guiding photons", program_, "count_guide_photons")
      .global(1)
      .arg("listed", listed)
      .arg("stored", stored_);
  recorder.read_back("number of guiding photons", stored_, [this](std::span<const std::byte> bytes) {
    std::memcpy(&collected_, bytes.data(), sizeof collected_);
  });
  return recorder.compile();
}

void GuidePhotons::record_order(const SceneBuffers& scene) {
  ScheduleRecorder recorder = scheduler_.record("order guiding photons", owner_);
  const BufferRef values = recorder.transient<uint32_t>("order of guiding photons", BIDIRECTIONAL_GUIDE_PHOTONS);
  PassBuilder key = recorder.pass("key guiding photons", program_, "key_guide_photons");
  scene.bind(key);
  key.global(BIDIRECTIONAL_GUIDE_PHOTONS)
      .slice(kSlice)
      .arg("photons", photons_)
      .arg("stored", stored_)
      .arg("keys", keys_)
      .arg("values", values);
  recorder.fill_zero("no narrow guiding photons", narrow_count_);
  primitives_.record_sort_pairs(recorder, "sort guiding photons", keys_, values, BIDIRECTIONAL_GUIDE_PHOTONS, kKeyBits);
  recorder.pass("order guiding photons", program_, "order_guide_photons")
      .global(BIDIRECTIONAL_GUIDE_PHOTONS)
      .slice(kSlice)
      .arg("photons", photons_)
      .arg("stored", stored_)
      .arg("values", values)
      .arg("ordered", ordered_)
      .arg("ordered_count", ordered_count_)
      .arg("narrow", narrow_count_);
  recorder.read_back("number of narrow guiding photons", narrow_count_,
                     [this](std::span<const std::byte> bytes) { std::memcpy(&narrow_, bytes.data(), sizeof narrow_); });
  order_ = recorder.compile();
}

void GuidePhotons::collect(Schedule& collect, uint32_t light_paths) {
  const bool never = collected_ == 0 && light_paths_ >= kPathsToGiveUp;
  if (never || collected_ == BIDIRECTIONAL_GUIDE_PHOTONS) return;
  scheduler_.run_to_end(collect);
  scheduler_.finish();
  light_paths_ += light_paths;
  const bool full = collected_ == BIDIRECTIONAL_GUIDE_PHOTONS;
  if (collected_ < BIDIRECTIONAL_GUIDE_WINDOW || (!full && collected_ < kGrowth * last_ordered_)) return;
  scheduler_.run_to_end(order_);
  scheduler_.finish();
  last_ordered_ = collected_;
}

void GuidePhotons::clear() {
  stored_.fill_zero();
  ordered_count_.fill_zero();
  collected_ = last_ordered_ = narrow_ = 0;
  light_paths_ = 0;
  rounds_ = 0;
  prepared_ = false;
}

void GuidePhotons::prepare(Schedule& collect_round, uint32_t light_paths) {
  collect(collect_round, light_paths);
  ++rounds_;
  const bool nothing = light_paths_ >= kPathsToLook && collected_ < BIDIRECTIONAL_GUIDE_WINDOW;
  prepared_ = rounds_ == kRounds || collected_ >= kEnough || nothing;
}

bool GuidePhotons::needs_light_paths() const { return narrow_ >= kMinNarrow && narrow_ >= kNarrowShare * light_paths_; }

size_t GuidePhotons::estimate_bytes() {
  // With the order and what sorting takes.
  return BIDIRECTIONAL_GUIDE_PHOTONS * (2 * sizeof(GuidePhoton) + 5 * sizeof(uint32_t));
}

size_t GuidePhotons::estimate_collect_bytes(const Plan& plan) { return plan.vertex_slots() * 2 * sizeof(uint32_t); }

}  // namespace lucarium::bidirectional
