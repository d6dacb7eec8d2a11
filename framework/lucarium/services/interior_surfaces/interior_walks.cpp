// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/interior_walks.h"

#include "lucarium/services/ray_ends.h"

namespace lucarium {

InteriorWalks::InteriorWalks(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                             const InteriorRule& rule)
    : scene_(&scene),
      intersector_(&intersector),
      rule_(rule),
      program_(device, SourceLibrary(),
               {"interior walks", {"lucarium/services/interior_surfaces/walks.cl"}, ray_end_defines(intersector)}) {}

void InteriorWalks::record(ScheduleRecorder& recorder, const RayBuffers& rays, const BufferRef& escaped) const {
  const BufferRef hits = recorder.transient<Hit>("ends of steps", rays.capacity);
  for (uint32_t step = 0; step < rule_.steps; ++step) {
    intersector_->record_closest(recorder, "steps of walks", rays, hits);
    PassBuilder pass = recorder.pass("step walks", program_, "step_walks");
    scene_->bind(pass);
    pass.global_by(rays.counter)
        .arg("walks", rays.counter)
        .arg("number", step)
        .arg("last", step + 1 == rule_.steps ? 1u : 0u)
        .arg("contact", rule_.contact)
        .arg("hits", hits)
        .arg("rays", rays.rays)
        .arg_if_present("ends", rays.ends)
        .arg("escaped", escaped);
  }
}

}  // namespace lucarium
