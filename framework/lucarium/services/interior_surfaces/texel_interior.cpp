// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/texel_interior.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/interior_point.h"

namespace lucarium {
namespace {

constexpr uint32_t kChunk = 16384;  // texel sides at a time
// Walks: a point from which 3 of 4 are caught passes for interior in 1 of 100 cases.
constexpr uint32_t kRounds = 16;

uint32_t samples_per_side(const SurfaceAtlas& atlas) {
  const auto samples = static_cast<uint32_t>(atlas.samples().count() / std::max(1u, atlas.info().texel_count));
  if (samples < 1 || samples > INTERIOR_MAX_SAMPLES)
    throw_error(ErrorClass::usage,
                "interior of texels: {} samples per texel side, not 1 to {}: see SurfaceAtlasOptions", samples,
                INTERIOR_MAX_SAMPLES);
  return samples;
}

}  // namespace

TexelInterior::TexelInterior(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                             const Intersector& intersector, const SurfaceAtlas& atlas, const std::string& owner,
                             const char* remedy, const InteriorRule& rule)
    : scheduler_(&scheduler),
      primitives_(device),
      walks_(device, scene, intersector, rule),
      program_(device, SourceLibrary(),
               {"interior of texels",
                {"lucarium/services/interior_surfaces/texel_interior.cl"},
                ray_end_defines(intersector)}),
      sides_(atlas.info().texel_count),
      samples_(samples_per_side(atlas)),
      chunk_(std::min(kChunk, sides_)),
      shares_(device, owner, "open shares of texel sides", sides_, remedy),
      hidden_(device, owner, "interior points of texel sides", sides_, remedy) {
  record(atlas, owner);
}

size_t TexelInterior::held_bytes(size_t sides) { return sides * (sizeof(float2) + sizeof(uint32_t)); }

size_t TexelInterior::estimate_bytes(size_t sides, size_t samples) {
  const size_t points = samples * std::min<size_t>(sides, kChunk);
  return held_bytes(sides) + points * (3 * sizeof(uint32_t) + sizeof(Ray) + sizeof(uint8_t)) +
         InteriorWalks::estimate_bytes(points);
}

void TexelInterior::record(const SurfaceAtlas& atlas, const std::string& owner) {
  const uint32_t capacity = chunk_ * samples_;
  ScheduleRecorder recorder = scheduler_->record("interior of texels", owner);
  first_ = recorder.variable("first", 0u);
  count_ = recorder.variable("count", chunk_);
  points_ = recorder.variable("points", capacity);
  const BufferRef states = recorder.transient<uint32_t>("states", capacity),
                  wanted = recorder.transient<uint32_t>("wanted", capacity),
                  list = recorder.transient<uint32_t>("points in doubt", capacity),
                  all = recorder.transient<uint32_t>("points", 1), active = recorder.transient<uint32_t>("active", 1),
                  rays = recorder.transient<Ray>("steps of walks", capacity),
                  ends = transient_ray_ends(recorder, walks_.intersector(), "ends of steps of walks", capacity),
                  escaped = recorder.transient<uint8_t>("escaped", capacity);
  recorder.pass("begin interior", program_, "begin_interior")
      .global(capacity)
      .arg("count", points_)
      .arg("states", states)
      .arg("wanted", wanted)
      .arg("total", all);
  for (uint32_t round = 0; round < kRounds; ++round) {
    primitives_.record_compact(recorder, "compact points in doubt", wanted, list, active, 0, all, 0, capacity);
    PassBuilder aim = recorder.pass("aim walks", program_, "aim_texel_walks");
    walks_.scene().bind(aim);
    atlas.bind(aim);
    aim.global_by(active)
        .arg("samples", samples_)
        .arg("first", first_)
        .arg("round_index", round)
        .arg("list", list)
        .arg("active", active)
        .arg("rays", rays)
        .arg_if_present("ends", ends)
        .arg("escaped", escaped);
    walks_.record(recorder, {rays, active, 0, capacity, ends}, escaped);
    recorder.pass("judge walks", program_, "judge_texel_walks")
        .global_by(active)
        .arg("round_index", round)
        .arg("list", list)
        .arg("active", active)
        .arg("escaped", escaped)
        .arg("states", states);
    if (round + 1 == kRounds) break;
    recorder.pass("choose walks", program_, "choose_texel_walks")
        .global(chunk_)
        .arg("sides", count_)
        .arg("samples", samples_)
        .arg("round_index", round)
        .arg("states", states)
        .arg("wanted", wanted);
  }
  recorder.pass("finish interior", program_, "finish_interior")
      .global(chunk_)
      .arg("first", first_)
      .arg("sides", count_)
      .arg("samples", samples_)
      .arg("states", states)
      .arg("shares", shares_)
      .arg("interior", hidden_);
  measure_ = recorder.compile();
}

bool TexelInterior::advance() {
  const uint32_t count = std::min(chunk_, sides_ - next_);
  measure_.set(first_, next_);
  measure_.set(count_, count);
  measure_.set(points_, count * samples_);
  if (scheduler_->run(measure_) == RunResult::cancelled) return false;
  next_ += count;
  if (!complete()) return true;
  scheduler_->finish();
  measure_ = {};  // and its memory
  return true;
}

}  // namespace lucarium
