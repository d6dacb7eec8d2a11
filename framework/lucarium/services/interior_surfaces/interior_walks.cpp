// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/interior_walks.h"

namespace lucarium {

InteriorWalks::InteriorWalks(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                             const InteriorRule& rule)
    : scene_(&scene),
      intersector_(&intersector),
      rule_(rule),
      program_(device, SourceLibrary(), {"interior walks", {"lucarium/services/interior_surfaces/walks.cl"}, {}}) {}

void InteriorWalks::record(ScheduleRecorder& recorder, const BufferRef& rays, const BufferRef& escaped,
                           const BufferRef& counter, uint32_t capacity) const {
  const BufferRef hits = recorder.transient<Hit>("ends of steps", capacity);
  for (uint32_t step = 0; step < rule_.steps; ++step) {
    intersector_->record_closest(recorder, "steps of walks", rays, hits, counter, 0, capacity);
    PassBuilder pass = recorder.pass("step walks", program_, "step_walks");
    scene_->bind(pass);
    pass.global_by(counter)
        .arg("walks", counter)
        .arg("number", step)
        .arg("last", step + 1 == rule_.steps ? 1u : 0u)
        .arg("contact", rule_.contact)
        .arg("hits", hits)
        .arg("rays", rays)
        .arg("escaped", escaped);
  }
}

}  // namespace lucarium
