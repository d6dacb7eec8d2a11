// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/texels/slot_exposure.h"

#include <algorithm>

#include "bundle_exchange/bundle_program.h"

namespace lucarium::bundle {
namespace {

constexpr uint32_t kChunk = 16384;  // slots at a time
constexpr uint32_t kRounds =
    16;  // of rays: a point that sees backs in 3 of 4 directions passes for hidden in 1 of 100 cases
const char* const kOwner = "bundle_exchange";
const char* const kFewerTexels = "lower texels";

}  // namespace

SlotExposure::SlotExposure(Device& device, KernelScheduler& scheduler, const Program& program,
                           const SceneBuffers& scene, const Intersector& intersector, const SurfaceAtlas& atlas)
    : scheduler_(&scheduler),
      primitives_(device),
      slots_(atlas.info().texel_count),
      chunk_(std::min(kChunk, slots_)),
      shares_(device, kOwner, "exposed shares of slots", slots_, kFewerTexels),
      hidden_(device, kOwner, "hidden points of slots", slots_, kFewerTexels) {
  record(program, scene, intersector, atlas);
}

size_t SlotExposure::estimate_bytes(size_t slots) {
  const size_t points = size_t{SLOT_POINTS} * std::min<size_t>(slots, kChunk);
  return slots * (sizeof(float2) + sizeof(uint32_t)) + points * (3 * sizeof(uint32_t) + sizeof(Ray) + sizeof(Hit));
}

void SlotExposure::record(const Program& program, const SceneBuffers& scene, const Intersector& intersector,
                          const SurfaceAtlas& atlas) {
  const uint32_t capacity = chunk_ * SLOT_POINTS;
  ScheduleRecorder recorder = scheduler_->record("what is hidden", kOwner);
  first_ = recorder.variable("first", 0u);
  count_ = recorder.variable("count", chunk_);
  points_ = recorder.variable("points", capacity);
  const BufferRef states = recorder.transient<uint32_t>("states", capacity),
                  wanted = recorder.transient<uint32_t>("wanted", capacity);
  const BufferRef list = recorder.transient<uint32_t>("points to probe", capacity);
  const BufferRef all = recorder.transient<uint32_t>("points", 1), active = recorder.transient<uint32_t>("active", 1);
  const BufferRef rays = recorder.transient<Ray>("probes", capacity), hits = recorder.transient<Hit>("hits", capacity);
  recorder.pass("begin probes", program, "begin_probes")
      .global(capacity)
      .arg("count", points_)
      .arg("states", states)
      .arg("wanted", wanted)
      .arg("total", all);
  for (uint32_t round = 0; round < kRounds; ++round) {
    primitives_.record_compact(recorder, "compact probes", wanted, list, active, 0, all, 0, capacity);
    PassBuilder aim = surface_pass(recorder, "aim probes", program, "aim_probes", scene, atlas);
    aim.global_by(active)
        .arg("first", first_)
        .arg("turn", round)
        .arg("list", list)
        .arg("active", active)
        .arg("rays", rays);
    intersector.record_closest(recorder, "probes", rays, hits, active, 0, capacity);
    PassBuilder judge = surface_pass(recorder, "judge probes", program, "judge_probes", scene, atlas);
    judge.global_by(active).arg("turn", round).arg("list", list).arg("active", active);
    judge.arg("rays", rays).arg("hits", hits).arg("states", states);
    if (round + 1 == kRounds) break;
    recorder.pass("choose probes", program, "choose_probes")
        .global(chunk_)
        .arg("slots", count_)
        .arg("turn", round)
        .arg("states", states)
        .arg("wanted", wanted);
  }
  recorder.pass("finish probes", program, "finish_probes")
      .global(chunk_)
      .arg("first", first_)
      .arg("slots", count_)
      .arg("states", states)
      .arg("exposure", shares_)
      .arg("hidden", hidden_);
  measure_ = recorder.compile();
}

bool SlotExposure::advance() {
  const uint32_t count = std::min(chunk_, slots_ - next_);
  measure_.set(first_, next_);
  measure_.set(count_, count);
  measure_.set(points_, count * SLOT_POINTS);
  if (scheduler_->run(measure_) == RunResult::cancelled) return false;
  next_ += count;
  if (!complete()) return true;
  scheduler_->finish();
  measure_ = {};  // and its memory
  return true;
}

}  // namespace lucarium::bundle
