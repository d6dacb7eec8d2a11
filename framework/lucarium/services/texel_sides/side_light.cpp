// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/texel_sides/side_light.h"

#include <algorithm>

#include "lucarium/base/seed.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {
namespace {

constexpr uint32_t kChunk = 65536;  // shadow rays of an iteration: about 20 ms

}  // namespace

SideLight::SideLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                     const Intersector& intersector, const SurfaceAtlas& atlas, const SideAccessibility& accessibility,
                     uint32_t kinds, const std::string& owner, const std::string& remedy, bool fill)
    : scheduler_(&scheduler),
      none_(kinds == 0),
      sides_(atlas.info().texel_count),
      chunk_(std::min(kChunk, sides_)),
      samples_(device, owner, "light at texel sides", chunk_, remedy),
      light_samples_(device, owner, "direct light of texel sides", size_t{accessibility.halves()} * sides_, remedy) {
  const Program program(device, SourceLibrary(),
                        {"services/texel_sides/sample_side_light",
                         {"lucarium/services/texel_sides/sample_side_light.cl"},
                         ray_end_defines(intersector)});
  ScheduleRecorder sample = scheduler_->record("sample light at texel sides", owner);
  first_ = sample.variable("first", 0u);
  round_ = sample.variable("round", 0u);
  sample_seed_ = sample.variable("seed", 0u);
  const auto bind_points = [&](PassBuilder& pass) {
    pass.arg("atlas_info", atlas.info())
        .arg("atlas_samples", atlas.samples())
        .arg("levels", accessibility.points())
        .arg("first", first_)
        .arg("sides", sides_)
        .arg("round_index", round_);
  };
  const LightAtPoints light(device, scene, intersector, program, chunk_, bind_points, owner, remedy);
  light.record_samples(
      sample, round_, sample_seed_, [&](PassBuilder& pass) { pass.arg("sums", samples_); }, kinds);
  sample_ = sample.compile();
  ScheduleRecorder scatter = scheduler_->record("light texel sides", owner);
  scatter_first_ = scatter.variable("first", 0u);
  scatter_count_ = scatter.variable("count", chunk_);
  scatter_round_ = scatter.variable("round", 0u);
  scatter.pass("light texel sides", program, "scatter_samples")
      .global(chunk_)
      .arg("first", scatter_first_)
      .arg("count", scatter_count_)
      .arg("sides", sides_)
      .arg("round_index", scatter_round_)
      .arg("levels", accessibility.points())
      .arg("samples", samples_)
      .arg("light_samples", light_samples_);
  const SideHalves halves = accessibility.side_halves();
  if (fill && halves.two()) {
    const Program fill_program(
        device, SourceLibrary(),
        {"services/texel_sides/fill_halves", {"lucarium/services/texel_sides/fill_halves.cl"}, {}});
    PassBuilder pass = scatter.pass("fill halves of texel sides", fill_program, "fill_halves");
    atlas.bind(pass);
    pass.global(chunk_)
        .arg("first", scatter_first_)
        .arg("count", scatter_count_)
        .arg("sides", sides_)
        .arg("levels", accessibility.points())
        .arg("covered", halves.covered)
        .arg("light_samples", light_samples_);
  }
  scatter_ = scatter.compile();
}

size_t SideLight::estimate_bytes(size_t sides, uint32_t halves) {
  const size_t chunk = std::min<size_t>(sides, kChunk);
  return chunk * sizeof(float4) + halves * sides * sizeof(float4) + LightAtPoints::estimate_bytes(chunk);
}

bool SideLight::sample() {
  const uint32_t first = static_cast<uint32_t>(position_ % sides_);
  sample_.set(first_, first);
  sample_.set(round_, static_cast<uint32_t>(position_ / sides_));
  // Points of different runs share their numbers in the buffer, so that each run has a seed of its own.
  sample_.set(sample_seed_, mixed_seed(seed_, first));
  pending_ = 0;
  if (scheduler_->run(sample_) == RunResult::cancelled) return false;
  pending_ = std::min(chunk_, sides_ - first);
  return true;
}

void SideLight::commit() {
  scatter_.set(scatter_first_, static_cast<uint32_t>(position_ % sides_));
  scatter_.set(scatter_count_, pending_);
  scatter_.set(scatter_round_, static_cast<uint32_t>(position_ / sides_));
  scheduler_->run_to_end(scatter_);
  position_ += pending_;
  pending_ = 0;
}

void SideLight::reset(uint32_t seed) {
  light_samples_.fill_zero();
  seed_ = seed;
  position_ = 0;
  pending_ = 0;
}

void SideLight::warm_up() {
  scheduler_->warm_up(sample_);
  scheduler_->warm_up(scatter_);
}

}  // namespace lucarium
