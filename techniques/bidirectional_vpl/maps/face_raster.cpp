// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/maps/face_raster.h"

namespace lucarium::bidirectional {

namespace {

LayeredRasterOptions raster_options(uint32_t side, const std::string& remedy = "") {
  LayeredRasterOptions options;
  options.max_width = options.max_height = side;
  options.perspective = true;
  options.remedy = remedy;
  return options;
}

}  // namespace

FaceRaster::FaceRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const std::string& name, uint32_t side,
                       const Program& program, const std::string& keep, const TypedBuffer<LayeredView>& views,
                       const TypedBuffer<uint32_t>& triangles, const std::string& remedy, const std::string& owner)
    : scheduler_(scheduler),
      raster_(scheduler, scene, raster_options(side, remedy), owner),
      generation_(raster_.generation()) {
  ScheduleRecorder recorder = scheduler.record("face of " + name, owner);
  number_ = recorder.variable("view", 0u);
  const size_t texels = size_t{side} * side;
  const BufferRef depth = recorder.transient<float>(name + ".depth", texels, remedy);
  const BufferRef seen = recorder.transient<uint32_t>(name + ".seen", texels, remedy);
  raster_.record_nearest(recorder, name, {views, number_}, depth, seen);
  recorder.pass(name + ".keep", program, keep)
      .global(texels)
      .arg("number", number_)
      .arg("side", side)
      .arg("seen", seen)
      .arg("triangles", triangles);
  schedule_ = recorder.compile();
}

bool FaceRaster::fill(uint32_t views) {
  for (uint32_t view = 0; view < views; ++view) {
    schedule_.set(number_, view);
    if (scheduler_.run(schedule_) == RunResult::cancelled) return false;
  }
  return true;
}

bool FaceRaster::update() {
  raster_.update();
  return raster_.generation() == generation_;
}

size_t FaceRaster::estimate_bytes(size_t triangles, uint32_t side) {
  return LayeredRaster::estimate_bytes(triangles, raster_options(side), {}) +
         size_t{side} * side * (sizeof(float) + sizeof(uint32_t));
}

}  // namespace lucarium::bidirectional
