// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/maps/maps.h"

#include <algorithm>

namespace lucarium::bidirectional {

namespace {

// Texels of a face (Tokuyoshi and Ogaki 2012, section 7).
constexpr uint32_t kRsmSide = 256, kDirectSide = 1024;

}  // namespace

Maps::Maps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
           const std::string& owner)
    : scheduler_(scheduler), scene_(scene), owner_(owner) {
  if (plan.rsm)
    rsm_ = std::make_unique<LightMaps>(device, scheduler, scene, "RSM", kRsmSide, "set light_trace=bvh", owner);
  if (plan.direct_maps)
    direct_ =
        std::make_unique<LightMaps>(device, scheduler, scene, "shadow maps", kDirectSide, "set direct=mis", owner);
}

void Maps::add_vpl_maps(Device& device, const Plan& plan, const LightVertices& vertices) {
  if (plan.vpl_maps) vpls_ = std::make_unique<VplMaps>(device, scheduler_, scene_, plan, vertices, owner_);
}

bool Maps::fill_lights(uint32_t seed, uint32_t sample) {
  return (!rsm_ || rsm_->fill(seed, sample)) && (!direct_ || direct_->fill(seed, sample));
}

bool Maps::fill_vpls(uint32_t seed, uint32_t sample) { return !vpls_ || vpls_->fill(seed, sample); }

void Maps::complete() {
  for (const auto& maps : {rsm_.get(), direct_.get()})
    if (maps) faces_ += maps->faces();
  if (vpls_) faces_ += vpls_->faces();
}

std::map<std::string, double> Maps::counters() const {
  if (!rsm_ && !direct_ && !vpls_) return {};
  return {{"map_faces", faces_}};
}

bool Maps::update() {
  bool same = true;
  for (const auto& maps : {rsm_.get(), direct_.get()})
    if (maps) same = maps->update() && same;
  if (vpls_) same = vpls_->update() && same;
  return same;
}

void Maps::warm_up() {
  for (const auto& maps : {rsm_.get(), direct_.get()})
    if (maps) maps->warm_up();
  if (vpls_) vpls_->warm_up();
}

size_t Maps::estimate_bytes(const Plan& plan, const Scene& scene) {
  const auto triangles = static_cast<size_t>(scene.triangle_count());
  const auto lights =
      static_cast<size_t>(std::count_if(scene.lights.begin(), scene.lights.end(),
                                        [](const SceneLight& light) { return light.type != LightType::directional; }));
  return (plan.rsm ? LightMaps::estimate_bytes(triangles, lights, kRsmSide) : 0) +
         (plan.direct_maps ? LightMaps::estimate_bytes(triangles, lights, kDirectSide) : 0) +
         (plan.vpl_maps ? VplMaps::estimate_bytes(plan, triangles) : 0);
}

}  // namespace lucarium::bidirectional
