// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/gbuffer/camera_rays.h"

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {

CameraRays::CameraRays(Device& device, KernelScheduler& scheduler, const Intersector& intersector, const Frame& frame,
                       const std::string& owner)
    : scheduler_(&scheduler),
      frame_(frame),
      rays_(device, owner, "camera rays", size_t{frame.width} * frame.height, remedies::lower_size),
      ends_(make_ray_ends(device, intersector, owner, "ends of camera rays", size_t{frame.width} * frame.height,
                          remedies::lower_size)),
      hits_(device, owner, "hits of camera rays", size_t{frame.width} * frame.height, remedies::lower_size),
      active_(device, owner, "number of camera rays", 1) {
  const Program program(
      device, SourceLibrary(),
      {"services/camera_rays", {"lucarium/services/gbuffer/generate_camera_rays.cl"}, ray_end_defines(intersector)});
  ScheduleRecorder recorder = scheduler.record("trace camera rays", owner);
  frame_variable_ = recorder.variable("frame", frame);
  sample_ = recorder.variable("sample", 0u);
  const uint32_t count = frame.width * frame.height;
  recorder.pass("generate camera rays", program, "generate_camera_rays")
      .global((count + LUCARIUM_CAMERA_RAYS_EACH - 1) / LUCARIUM_CAMERA_RAYS_EACH)
      .arg("frame", frame_variable_)
      .arg("sample_index", sample_)
      .arg("rays", rays_)
      .arg_if_present("ends", ends_)
      .arg("active", active_);
  intersector.record_closest(recorder, "closest hit", RayBuffers{rays_, active_, 0, count, ends_, frame.width}, hits_);
  trace_ = recorder.compile();
}

bool CameraRays::trace(uint32_t sample_index) {
  trace_.set(frame_variable_, frame_);
  trace_.set(sample_, sample_index);
  return scheduler_->run(trace_) == RunResult::done;
}

void CameraRays::set_frame(const Frame& frame) {
  if (frame.width != frame_.width || frame.height != frame_.height)
    throw Error(ErrorClass::internal, "CameraRays::set_frame: the image size cannot change");
  frame_ = frame;
}

size_t CameraRays::estimate_bytes(uint32_t width, uint32_t height, bool ray_ends) {
  return size_t{width} * height * (sizeof(Ray) + sizeof(Hit) + (ray_ends ? sizeof(RayEnds) : 0));
}

}  // namespace lucarium
