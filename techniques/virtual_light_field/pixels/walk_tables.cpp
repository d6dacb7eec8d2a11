// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/pixels/walk_tables.h"

#include "lucarium/compute/device/remedies.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {

WalkTables::WalkTables(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                       const LightField& field, const TypedBuffer<float4>& side_albedo, bool fold)
    : scheduler_(&scheduler),
      field_(&field),
      triangles_(device, technique_name, "triangles of walks", scene.scene_triangles.count(), remedies::lower_size),
      sides_(device, technique_name, "materials of walks", 2 * scene.scene_materials.count(), remedies::lower_size),
      light_(device, technique_name, "light of walks", field.shown().count(), remedies::lower_texels) {
  const Program program = make_field_program(device, "pixels/walk_tables");
  const auto triangles = static_cast<uint32_t>(triangles_.count()), sides = static_cast<uint32_t>(sides_.count()),
             entries = static_cast<uint32_t>(light_.count());
  ScheduleRecorder of_scene = scheduler.record("list surfaces of walks", technique_name);
  PassBuilder of_triangles = of_scene.pass("list triangles", program, "list_walk_triangles");
  scene.bind(of_triangles);
  of_triangles.global(triangles)
      .arg("count", triangles)
      .arg("atlas_triangles", atlas.triangles())
      .arg("walk_triangles", triangles_);
  PassBuilder of_sides = of_scene.pass("list materials", program, "list_walk_sides");
  scene.bind(of_sides);
  of_sides.global(sides).arg("count", sides).arg("walk_sides", sides_);
  list_ = of_scene.compile();
  ScheduleRecorder of_field = scheduler.record("list light of walks", technique_name);
  PassBuilder of_light = of_field.pass("list light", program, "list_walk_light");
  field.maps().bind(of_light);
  of_light.global(entries)
      .arg("count", entries)
      .arg("sides", atlas.info().texel_count)
      .arg("fold", fold ? 1u : 0u)
      .arg("shown", field.shown())
      .arg("shown_direct", field.shown_direct())
      .arg("side_albedo", side_albedo)
      .arg("walk_light", light_);
  list_light_ = of_field.compile();
}

void WalkTables::update() {
  const uint32_t sweeps = field_->shown_sweeps();
  if (sweeps_ == sweeps) return;
  if (sweeps_ == 0) scheduler_->run_to_end(list_);
  scheduler_->run_to_end(list_light_);
  sweeps_ = sweeps;
}

void WalkTables::bind(PassBuilder& pass) const {
  pass.arg("walk_triangles", triangles_).arg("walk_sides", sides_).arg("walk_light", light_);
}

void WalkTables::warm_up() {
  scheduler_->warm_up(list_);
  scheduler_->warm_up(list_light_);
}

size_t WalkTables::estimate_bytes(size_t triangles, size_t materials, size_t entries) {
  return triangles * sizeof(WalkTriangle) + 2 * materials * sizeof(WalkSide) + entries * sizeof(WalkLight);
}

}  // namespace lucarium::vlf
