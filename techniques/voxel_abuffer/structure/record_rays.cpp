// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/ray_shares/ray_shares.h"
#include "voxel_abuffer/structure/state.h"

namespace lucarium::abuffer {

void VoxelAbuffer::State::record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel,
                                 const RayBuffers& rays, const char* result_name, const BufferRef& result) const {
  PassBuilder pass = recorder.pass(pass_name, search_program, kernel);
  trace_by_shares(pass, rays, *device);
  pass.arg("rays", rays.rays)
      .arg(result_name, result)
      .arg("abuffer_grid", grid_buffer)
      .arg("abuffer_bricks", bricks)
      .arg("abuffer_voxels", voxels)
      .arg("abuffer_triangles", triangles);
  if (exact || (parity && options.intersect != Intersect::plane)) pass.arg("abuffer_cells", cells);
  if (exact)
    pass.arg("abuffer_exact_start", exact->start())
        .arg("abuffer_exact_depths", exact->depths())
        .arg("abuffer_exact_fragments", exact->fragments());
  if (parity)
    pass.arg("ends", rays.ends)
        .arg("abuffer_classes", triangle_classes)
        .arg("abuffer_offset", options.offset)
        .arg("abuffer_bisections", options.bisections)
        .arg("abuffer_parity_start", parity->start())
        .arg("abuffer_parity_depths", parity->depths())
        .arg("abuffer_parity_fragments", parity->fragments())
        .arg_if_present("abuffer_attributes", parity->attributes());
  pass.arg_if_present("abuffer_work", work);
  if (search_alpha) buffers->bind(pass);
}

void VoxelAbuffer::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                                  const BufferRef& hits) const {
  state_->record(recorder, pass_name, "abuffer_closest", rays, "hits", hits);
}

void VoxelAbuffer::record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                              const BufferRef& occluded) const {
  state_->record(recorder, pass_name, "abuffer_any", rays, "occluded", occluded);
}

}  // namespace lucarium::abuffer
