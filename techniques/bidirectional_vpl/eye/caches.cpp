// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/eye/caches.h"

#include "bidirectional_vpl/base/slices.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

const char* const kWithoutCaches = "lower --size or set caches=off";

}  // namespace

Caches::Caches(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
               const Frame& frame, const Plan& plan, const std::string& owner)
    : scheduler_(scheduler),
      frame_(frame),
      before_(frame),
      pixels_(plan.settings.pixels),
      surfaces_(device, scheduler, scene, intersector, frame, owner),
      program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/eye/caches"}, {})),
      caches_(device, owner, "caches of the frame before", size_t{BIDIRECTIONAL_SUB_PIXELS} * pixels_, kWithoutCaches),
      kept_(device, owner, "caches", size_t{BIDIRECTIONAL_SUB_PIXELS} * pixels_, kWithoutCaches),
      positions_(device, owner, "vertices of the frame before", scene.scene_vertices.count(), kWithoutCaches),
      present_(device, owner, "vertices of the frame", scene.scene_vertices.count(), kWithoutCaches),
      reused_(device, owner, "light from caches", pixels_, kWithoutCaches) {
  record_look_up(scene, owner);
  record_advance(scene, owner);
}

void Caches::record_look_up(const SceneBuffers& scene, const std::string& owner) {
  ScheduleRecorder recorder = scheduler_.record("look up caches", owner);
  before_variable_ = recorder.variable("frame before", before_);
  first_ = recorder.variable("first of the sub-pixel", 0u);
  computed_ = recorder.variable("all computed", 1u);
  recorder.pass("reproject caches", program_, "reproject_caches")
      .global(pixels_)
      .slice(kSlice)
      .arg("scene_triangles", scene.scene_triangles)
      .arg("positions", positions_)
      .arg("before", before_variable_)
      .arg("caches", caches_)
      .arg("first", first_)
      .arg("computed", computed_)
      .arg("points", surfaces_.points())
      .arg("reused", reused_);
  look_up_ = recorder.compile();
}

void Caches::record_advance(const SceneBuffers& scene, const std::string& owner) {
  ScheduleRecorder recorder = scheduler_.record("next frame of caches", owner);
  begin_ = recorder.variable("begin", 1u);
  const auto vertices = static_cast<uint32_t>(present_.count());
  recorder.pass("advance positions", program_, "advance_positions")
      .global(vertices)
      .slice(kSlice)
      .arg("scene_vertices", scene.scene_vertices)
      .arg("count", vertices)
      .arg("begin", begin_)
      .arg("present", present_)
      .arg("positions", positions_);
  recorder.pass("advance caches", program_, "advance_caches")
      .global(BIDIRECTIONAL_SUB_PIXELS * pixels_)
      .slice(kSlice)
      .arg("count", BIDIRECTIONAL_SUB_PIXELS * pixels_)
      .arg("begin", begin_)
      .arg("kept", kept_)
      .arg("caches", caches_);
  advance_ = recorder.compile();
}

void Caches::record_keep(ScheduleRecorder& recorder, const TypedBuffer<float4>& sample, uint32_t layer) {
  keep_first_ = recorder.variable("first of the sub-pixel", 0u);
  recorder.pass("keep in caches", program_, "keep_in_caches")
      .global(pixels_)
      .arg("points", surfaces_.points())
      .arg("reused", reused_)
      .arg("first", keep_first_)
      .arg("layer", layer)
      .arg("pixels", pixels_)
      .arg("sample", sample)
      .arg("kept", kept_);
}

void Caches::prepare_keep(Schedule& schedule) const { schedule.set(keep_first_, first_of(index_)); }

bool Caches::look_up(uint32_t index) {
  index_ = index;
  if (!surfaces_.render(index)) return false;
  const bool computed = frames_ == 0 || index % BIDIRECTIONAL_SUB_PIXELS == frames_ % BIDIRECTIONAL_SUB_PIXELS;
  look_up_.set(before_variable_, before_);
  look_up_.set(first_, first_of(index));
  look_up_.set(computed_, computed ? 1u : 0u);
  return scheduler_.run(look_up_) != RunResult::cancelled;
}

void Caches::advance(const Frame& frame, bool begin) {
  before_ = frame_;
  frame_ = frame;
  frames_ = begin ? 0 : frames_ + 1;
  surfaces_.set_frame(frame);
  advance_.set(begin_, begin ? 1u : 0u);
  scheduler_.run_to_end(advance_);
  scheduler_.finish();
}

void Caches::next_frame(const Frame& frame) { advance(frame, false); }

void Caches::clear(const Frame& frame) { advance(frame, true); }

void Caches::warm_up() {
  surfaces_.warm_up();
  scheduler_.warm_up(look_up_);
}

size_t Caches::estimate_bytes(const Plan& plan, size_t vertices, bool ray_ends) {
  const size_t caches = 2 * BIDIRECTIONAL_SUB_PIXELS * sizeof(CachedPixel) + sizeof(float4);
  return GBuffer::estimate_bytes(plan.settings.pixels, 1, ray_ends) + plan.settings.pixels * caches +
         2 * vertices * sizeof(float4);
}

}  // namespace lucarium::bidirectional
