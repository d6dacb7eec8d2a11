// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/pixels/pixel_gather.h"

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"
#include "lucarium/compute/device/remedies.h"

namespace lucarium::bundle {
PixelGather::PixelGather(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                         const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
                         const TypedBuffer<GBufferPoint>& points, const Options& options)
    : program_(program),
      scheduler_(&scheduler),
      scene_(&scene),
      intersector_(&intersector),
      atlas_(&atlas),
      options_(options),
      points_(points),
      halves_(means.halves()),
      records_(means.records()),
      contribution_(device, technique_name, "gathered in a batch", 2 * size_t{options.pixels}, remedies::lower_size),
      gathered_(device, technique_name, "gathered by bundles", 2 * size_t{options.pixels}, remedies::lower_size),
      shares_(device, technique_name, "shares of gathered light", options.pixels, remedies::lower_size),
      rays_(device, technique_name, "rays of pixels not found", options.pixels, remedies::lower_size),
      count_(device, technique_name, "number of pixels", std::vector<uint32_t>{options.pixels}) {
  ScheduleRecorder recorder = scheduler_->record("add gathered light", technique_name);
  directions_ = recorder.variable("directions", 0u);
  recorder.pass("add gathered light", program_, "add_gathered")
      .global(options_.pixels)
      .arg("count", options_.pixels)
      .arg("directions", directions_)
      .arg("contribution", contribution_)
      .arg("gathered", gathered_);
  add_ = recorder.compile();
  restart();
}

size_t PixelGather::estimate_bytes(size_t pixels) { return pixels * (5 * sizeof(float4) + sizeof(Ray) + sizeof(Hit)); }

void PixelGather::record(ScheduleRecorder& recorder, const LayeredRaster::Stored& stored,
                         const TypedBuffer<LayeredView>& views, const TypedBuffer<float4>& ends,
                         const Variable<uint32_t>& first, const Variable<float>& weight) const {
  const BufferRef hits = recorder.transient<Hit>("hits of pixels", options_.pixels);
  PassBuilder gather = surface_pass(recorder, "gather at pixels", program_, "gather_pixels", *scene_, *atlas_);
  halves_.bind(gather);
  gather.global(options_.pixels)
      .arg("points", points_)
      .arg("count", options_.pixels)
      .arg("whole", options_.whole ? 1u : 0u)
      .arg("min_alpha", options_.min_alpha)
      .arg("first", first)
      .arg("weight", weight)
      .arg("views", views)
      .arg("pixel_start", stored.pixel_start)
      .arg("fragments", stored.fragments)
      .arg("ends", ends)
      .arg("records", records_)
      .arg("contribution", contribution_)
      .arg("rays", rays_)
      .arg("shares", shares_);
  intersector_->record_closest(recorder, "rays of pixels not found", {rays_, count_, 0, options_.pixels}, hits);
  PassBuilder missed =
      surface_pass(recorder, "gather at pixels not found", program_, "gather_missed", *scene_, *atlas_);
  halves_.bind(missed);
  missed.global(options_.pixels)
      .arg("count", options_.pixels)
      .arg("views", views)
      .arg("ends", ends)
      .arg("rays", rays_)
      .arg("hits", hits)
      .arg("shares", shares_)
      .arg("records", records_)
      .arg("contribution", contribution_);
}

void PixelGather::commit(uint32_t directions) {
  add_.set(directions_, directions);
  scheduler_->run_to_end(add_);
}

void PixelGather::restart() {
  scheduler_->finish();
  gathered_.fill_zero();
}

void PixelGather::warm_up() { scheduler_->warm_up(add_); }

}  // namespace lucarium::bundle
