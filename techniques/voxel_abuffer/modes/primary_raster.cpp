// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/modes/primary_raster.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {
namespace {

const char* const kRemedy = "set primary=trace, or lower --size";

LayeredRasterOptions raster_options(uint32_t width, uint32_t height) {
  return {.max_width = width, .max_height = height, .perspective = true, .keep_alpha = true, .remedy = kRemedy};
}

}  // namespace

LayeredView camera_view(const Frame& frame, const Bounds& bounds) {
  const Camera& camera = frame.camera;
  // p = eye + W (direction + sx · direction_dx + sy · direction_dy); x grows with sx, y against sy.
  const glm::mat3 axes(camera.direction_dx.xyz(), camera.direction_dy.xyz(), camera.direction.xyz());
  const glm::mat3 rows = glm::transpose(glm::inverse(axes));
  const glm::vec3 eye = camera.origin.xyz();
  const auto row = [&](const glm::vec3& axis) { return float4(axis, -glm::dot(axis, eye)); };
  LayeredView view{};
  view.row_x = row(0.5f * static_cast<float>(frame.width) * (rows[0] + rows[2]));
  view.row_y = row(0.5f * static_cast<float>(frame.height) * (rows[2] - rows[1]));
  view.row_w = row(rows[2]);
  float near = INFINITY, far = 0;
  for (int corner = 0; corner < 8 && !bounds.empty(); ++corner) {
    const glm::vec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                      corner & 4 ? bounds.max.z : bounds.min.z);
    const float depth = glm::dot(rows[2], p - eye);
    near = std::min(near, depth);
    far = std::max(far, depth);
  }
  if (!(far > 0)) far = 1;  // the scene lies behind the eye
  far *= 1.001f;
  view.depth_min = std::max(0.999f * near, 1e-5f * far);
  if (!(view.depth_min < far)) view.depth_min = 1e-5f * far;
  view.depth_scale = 1 / (far - view.depth_min);
  view.width = frame.width;
  view.height = frame.height;
  return view;
}

PrimaryRaster::PrimaryRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& others,
                             uint32_t width, uint32_t height)
    : scheduler_(&scheduler),
      scene_(&scene),
      others_(&others),
      raster_(scheduler, scene, raster_options(width, height), technique_name),
      program_(make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/modes/primary_raster"})),
      view_(scheduler.device(), technique_name, "camera view", 1),
      eye_(scheduler.device(), technique_name, "eye", 1),
      depth_(scheduler.device(), technique_name, "depths of pixels", size_t{width} * height, kRemedy),
      triangle_(scheduler.device(), technique_name, "triangles of pixels", size_t{width} * height, kRemedy) {}

bool PrimaryRaster::possible(const Frame& frame) {
  const glm::vec3 x = frame.camera.origin_dx.xyz(), y = frame.camera.origin_dy.xyz();
  return frame.pixel_sampling == LUCARIUM_PIXEL_CENTRE && x == glm::vec3(0) && y == glm::vec3(0) &&
         std::max(frame.width, frame.height) <= LAYERED_MAX_EDGE;
}

void PrimaryRaster::record() {
  ScheduleRecorder recorder = scheduler_->record("rasterize primary", technique_name);
  raster_.record_nearest(recorder, "primary", {view_, recorder.variable("primary.view", 0u), {}}, depth_, triangle_);
  schedule_ = recorder.compile();
  recorded_ = raster_.generation();
}

void PrimaryRaster::rasterize(const Frame& frame) {
  if (!possible(frame))
    throw Error(ErrorClass::usage,
                "voxel_abuffer: primary=raster needs a perspective camera and --pixel-sampling center; set "
                "primary=trace");
  scheduler_->finish();
  const SceneInfo& info = scene_->info();
  view_.upload({camera_view(frame, {info.bounds_min.xyz(), info.bounds_max.xyz()})});
  eye_.upload({frame.camera.origin});
  if (!schedule_ || recorded_ != raster_.generation()) record();
  scheduler_->run_to_end(schedule_);
}

void PrimaryRaster::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                                   const BufferRef& hits) const {
  const BufferRef others = recorder.transient<Ray>(pass_name + ", rays to trace", rays.capacity, kRemedy);
  const BufferRef seen = recorder.transient<Hit>(pass_name + ", seen", rays.capacity, kRemedy);
  PassBuilder look = recorder.pass(pass_name + ", look up pixels", program_, "look_up_primary");
  scene_->bind(look);
  look.global(rays.capacity)
      .arg("views", view_)
      .arg("eye", eye_)
      .arg("triangles", triangle_)
      .arg("depths", depth_)
      .arg("counter", rays.counter)
      .arg("counter_index", rays.counter_index)
      .arg("capacity", rays.capacity)
      .arg("rays", rays.rays)
      .arg("others", others)
      .arg("seen", seen);
  others_->record_closest(recorder, pass_name,
                          {others, rays.counter, rays.counter_index, rays.capacity, rays.ends, rays.row}, hits);
  recorder.pass(pass_name + ", take pixels", program_, "take_primary")
      .global(rays.capacity)
      .arg("counter", rays.counter)
      .arg("counter_index", rays.counter_index)
      .arg("capacity", rays.capacity)
      .arg("seen", seen)
      .arg("hits", hits);
}

size_t PrimaryRaster::estimate_bytes(size_t triangles, uint32_t width, uint32_t height, size_t rays) {
  return LayeredRaster::estimate_bytes(triangles, raster_options(width, height), {}) +
         size_t{width} * height * (sizeof(float) + sizeof(uint32_t)) + rays * (sizeof(Ray) + sizeof(Hit));
}

}  // namespace lucarium::abuffer
