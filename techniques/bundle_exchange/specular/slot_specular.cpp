// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/slot_specular.h"

#include <cmath>
#include <limits>

namespace lucarium::bundle {
namespace {

constexpr int kUsualWindow = 32;

SlotRing::Options ring_options(const Parameters& parameters) {
  SlotRing::Options options;
  options.window = static_cast<uint32_t>(parameters.glossy_window);
  options.batch = static_cast<uint32_t>(parameters.batch);
  options.by_share = parameters.glossy_norm == GlossyNorm::self;
  return options;
}

}  // namespace

float SlotSpecular::alpha_least(const Parameters& parameters) {
  const int window = uses_ring(parameters) ? parameters.glossy_window : kUsualWindow;
  return parameters.alpha_ring > 0 ? parameters.alpha_ring : std::sqrt(2.f / static_cast<float>(window));
}

SlotSpecular::SlotSpecular(Device& device, KernelScheduler& scheduler, const Program& program,
                           const SceneBuffers& scene, const Intersector& intersector, const SurfaceAtlas& atlas,
                           const SlotMeans& means, const Parameters& parameters, bool punctual, int max_bounces,
                           bool by_area) {
  const float least = uses_ring(parameters) ? alpha_least(parameters) : std::numeric_limits<float>::infinity();
  const SlotHops::Lists lists = SlotHops::specular_slots(atlas, least);
  SlotHops::Options hops;
  hops.share = parameters.hop_share;
  hops.punctual = punctual;
  hops.max_bounces = max_bounces;
  const auto make_hops = [&](const SlotHops::List& list) {
    return std::make_unique<SlotHops>(device, scheduler, program, scene, intersector, atlas, means, list, hops);
  };
  if (!lists.traced.slots.empty()) hops_ = make_hops(lists.traced);
  if (lists.glossy.slots.empty()) return;
  SlotRing::Options options = ring_options(parameters);
  options.by_area = by_area;
  options.onto = hops.only_punctual = punctual;
  if (punctual) light_ = make_hops(lists.glossy);
  ring_ = std::make_unique<SlotRing>(device, scheduler, program, scene, atlas, means, lists.glossy.slots, options);
}

size_t SlotSpecular::estimate_bytes(size_t slots, const Channels& channels, const Parameters& parameters) {
  const size_t ring = uses_ring(parameters) ? SlotRing::estimate_bytes(slots, channels, ring_options(parameters)) : 0;
  return SlotHops::estimate_bytes(slots, channels) + ring;
}

void SlotSpecular::begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count) {
  if (ring_) ring_->begin_batch(sequence, first, count);
}

bool SlotSpecular::send(const BundleDirection& direction, uint32_t i, uint32_t seed, bool lit) {
  return (!hops_ || hops_->find(direction, seed, lit)) && (!light_ || light_->find(direction, seed ^ 0x6c69u, lit)) &&
         (!ring_ || ring_->send(i));
}

void SlotSpecular::receive(uint32_t i) {
  if (ring_) ring_->receive(i);
}

void SlotSpecular::commit() {
  if (ring_) ring_->commit();
}

void SlotSpecular::reset() {
  if (hops_) hops_->reset_count();
  if (light_) light_->reset_count();
  if (ring_) ring_->reset();
}

void SlotSpecular::warm_up() {
  if (hops_) hops_->warm_up();
  if (light_) light_->warm_up();
  if (ring_) ring_->warm_up();
}

}  // namespace lucarium::bundle
