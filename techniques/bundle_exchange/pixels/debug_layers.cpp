// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/pixels/debug_layers.h"

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"
#include "bundle_exchange/pixels/side_state.h"

namespace lucarium::bundle {
DebugLayers::DebugLayers(Device& device, KernelScheduler& scheduler, const SurfaceAtlas& atlas, const SideMeans& means,
                         const SidePreview* preview, const SideState* sides, const CameraLight& camera)
    : scheduler_(&scheduler), camera_(&camera) {
  const std::vector<std::string> parts = {"exchanged_direct", "diffuse_exchange", "specular_chains", "bundle_gather"};
  parts_ = make_images(device, parts);
  const Program program = make_bundle_program(device, "pixels/add_light_parts", means.channels().defines());
  ScheduleRecorder recorder = scheduler.record("add debug layers", technique_name);
  atlas_weight_ = recorder.variable("atlas_weight", 1.f);
  record_parts(recorder, program, atlas, means.halves(), means.shown(), means.shown_direct(), parts_);
  if (preview) {
    smooth_parts_ = make_images(device, parts);
    record_parts(recorder, program, atlas, means.halves(), preview->shown(), preview->shown_direct(), smooth_parts_);
  }
  if (sides) record_states(recorder, program, device, atlas, means.halves(), *sides);
  add_ = recorder.compile();
  clear();
}

void DebugLayers::record_states(ScheduleRecorder& recorder, const Program& program, Device& device,
                                const SurfaceAtlas& atlas, const SideHalves& halves, const SideState& sides) {
  states_ = make_images(device, {"accessibility", "balance", "direction_history"});
  PassBuilder state = recorder.pass("add state of texel sides", program, "add_side_state");
  atlas.bind(state);
  halves.bind(state);
  state.global(camera_->pixels())
      .arg("points", camera_->points())
      .arg("count", camera_->pixels())
      .arg("atlas_weight", atlas_weight_)
      .arg("shares", sides.accessibility())
      .arg("balances", sides.balance())
      .arg("histories", sides.history());
  for (size_t k = 0; k < states_.names.size(); ++k) state.arg(states_.names[k], states_.means[k]);
}

DebugLayers::Images DebugLayers::make_images(Device& device, const std::vector<std::string>& names) const {
  Images result;
  result.names = names;
  for (const std::string& name : names)
    result.means.emplace_back(device, technique_name, "layer " + name, camera_->pixels(), no_debug_layers);
  return result;
}

void DebugLayers::record_parts(ScheduleRecorder& recorder, const Program& program, const SurfaceAtlas& atlas,
                               const SideHalves& halves, const TypedBuffer<float4>& shown,
                               const TypedBuffer<float4>& shown_direct, const Images& parts) const {
  PassBuilder add = recorder.pass("add parts of the light", program, "add_light_parts");
  atlas.bind(add);
  halves.bind(add);
  add.global(camera_->pixels())
      .arg("points", camera_->points())
      .arg("count", camera_->pixels())
      .arg("atlas_weight", atlas_weight_)
      .arg("whole", camera_->whole() ? 1u : 0u)
      .arg("shown", shown)
      .arg("shown_direct", shown_direct)
      .arg("bundled", camera_->bundled())
      .arg("gathered", camera_->gathered());
  for (size_t k = 0; k < parts.names.size(); ++k) add.arg(parts.names[k], parts.means[k]);
}

void DebugLayers::commit() {
  add_.set(atlas_weight_, camera_->atlas_weight());
  scheduler_->run_to_end(add_);
}

void DebugLayers::clear() {
  for (Images* images : {&parts_, &smooth_parts_, &states_})
    for (TypedBuffer<float4>& mean : images->means) mean.fill_zero();
}

void DebugLayers::warm_up() { scheduler_->warm_up(add_); }

void DebugLayers::write(Film& film, bool smoothed) const {
  scheduler_->finish();
  for (const Images* images : {smoothed ? &smooth_parts_ : &parts_, &states_})
    for (size_t k = 0; k < images->names.size(); ++k) {
      const std::vector<float4> means = images->means[k].download();
      FilmLayer& layer = film.layer(images->names[k]);
      for (size_t p = 0; p < means.size(); ++p)
        for (size_t c = 0; c < 3; ++c) layer.pixels[3 * p + c] = (&means[p].x)[c];
    }
}

}  // namespace lucarium::bundle
