// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/pixels/subfield_view.h"

#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {
SubfieldView::SubfieldView(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                           const Intersector& intersector, const SurfaceAtlas& atlas,
                           const TypedBuffer<float4>& side_albedo, const TypedBuffer<float>& inverse_scale,
                           const LightField& field, const Options& options)
    : scheduler_(&scheduler),
      sums_(device, technique_name, size_t{options.width} * options.height, {"subfield"}),
      count_(device, technique_name, "number of pixels", std::vector<uint32_t>{options.width * options.height}) {
  const uint32_t pixels = options.width * options.height;
  const Program program = make_field_program(device, "pixels/show_subfield", ray_end_defines(intersector));
  ScheduleRecorder recorder = scheduler.record("show subfield", technique_name);
  const BufferRef rays = recorder.transient<Ray>("rays of a line", pixels, remedies::lower_size),
                  ends = transient_ray_ends(recorder, intersector, "ends of rays of a line", pixels),
                  hits = recorder.transient<Hit>("hits of a line", pixels, remedies::lower_size);
  const auto bind = [&](PassBuilder& pass) {
    field.maps().bind(pass);
    pass.global(pixels)
        .arg("count", pixels)
        .arg("width", options.width)
        .arg("height", options.height)
        .arg("line", options.line)
        .arg("rays", rays);
  };
  PassBuilder aim = recorder.pass("aim along a line", program, "aim_along_line");
  bind(aim);
  aim.arg("reach", options.reach).arg("seed", options.seed).arg_if_present("ends", ends);
  intersector.record_closest(recorder, "rays of a line", {rays, count_, 0, pixels, ends}, hits);
  PassBuilder show = recorder.pass("show subfield", program, "show_subfield");
  scene.bind(show);
  atlas.bind(show);
  bind(show);
  field.halves().bind(show);
  show.arg("inverse_scale", inverse_scale)
      .arg("split", field.split() ? 1u : 0u)
      .arg("fold", options.fold ? 1u : 0u)
      .arg("side_albedo", side_albedo)
      .arg("shown_direct", field.shown_direct())
      .arg("shown", field.shown())
      .arg("direct", field.direct())
      .arg("total", field.total())
      .arg("hits", hits)
      .arg("layer", sums_["subfield"]);
  show_ = recorder.compile();
}

void SubfieldView::show() { scheduler_->run_to_end(show_); }

size_t SubfieldView::estimate_bytes(size_t pixels) {
  return LayerSums::estimate_bytes(pixels, 1) + pixels * (sizeof(Ray) + sizeof(Hit));
}

}  // namespace lucarium::vlf
