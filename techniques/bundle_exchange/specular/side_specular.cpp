// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/side_specular.h"

#include <cmath>
#include <limits>

namespace lucarium::bundle {
namespace {

constexpr int kUsualWindow = 32;

DirectionHistory::Options history_options(const Parameters& parameters) {
  DirectionHistory::Options options;
  options.window = static_cast<uint32_t>(parameters.glossy_window);
  options.batch = static_cast<uint32_t>(parameters.batch);
  options.by_share = parameters.glossy_norm == GlossyNorm::self;
  return options;
}

}  // namespace

float SideSpecular::min_alpha(const Parameters& parameters) {
  const int window = uses_history(parameters) ? parameters.glossy_window : kUsualWindow;
  return parameters.history_alpha > 0 ? parameters.history_alpha : std::sqrt(2.f / static_cast<float>(window));
}

SideSpecular::SideSpecular(Device& device, KernelScheduler& scheduler, const Program& program,
                           const SceneBuffers& scene, const Intersector& intersector, const SurfaceAtlas& atlas,
                           const SideMeans& means, const Parameters& parameters, bool punctual, int max_bounces,
                           bool by_area) {
  const float least = uses_history(parameters) ? min_alpha(parameters) : std::numeric_limits<float>::infinity();
  const SideChains::Lists lists = SideChains::specular_sides(atlas, least);
  SideChains::Options chains;
  chains.share = parameters.chain_share;
  chains.punctual = punctual;
  chains.max_bounces = max_bounces;
  const auto make_chains = [&](const SideChains::List& list) {
    return std::make_unique<SideChains>(device, scheduler, program, scene, intersector, atlas, means, list, chains);
  };
  if (!lists.traced.sides.empty()) chains_ = make_chains(lists.traced);
  if (lists.glossy.sides.empty()) return;
  DirectionHistory::Options options = history_options(parameters);
  options.by_area = by_area;
  options.adds = chains.only_punctual = punctual;
  if (punctual) light_ = make_chains(lists.glossy);
  std::vector<uint32_t> sides = lists.glossy.sides;
  if (means.halves().two())
    for (const uint32_t side : lists.glossy.sides) sides.push_back(means.halves().sides + side);
  history_ = std::make_unique<DirectionHistory>(device, scheduler, program, scene, atlas, means, sides, options);
}

size_t SideSpecular::estimate_bytes(size_t sides, uint32_t halves, const Channels& channels,
                                    const Parameters& parameters) {
  const size_t history = uses_history(parameters)
                             ? DirectionHistory::estimate_bytes(halves * sides, channels, history_options(parameters))
                             : 0;
  return SideChains::estimate_bytes(sides, channels) + history;
}

void SideSpecular::begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count) {
  if (history_) history_->begin_batch(sequence, first, count);
}

bool SideSpecular::send(const BundleDirection& direction, uint32_t i, uint32_t seed, bool lit) {
  return (!chains_ || chains_->find(direction, seed, lit)) &&
         (!light_ || light_->find(direction, seed ^ 0x6c69u, lit)) && (!history_ || history_->send(i));
}

void SideSpecular::receive(uint32_t i) {
  if (history_) history_->receive(i);
}

void SideSpecular::commit() {
  if (history_) history_->commit();
}

void SideSpecular::reset() {
  if (chains_) chains_->reset_count();
  if (light_) light_->reset_count();
  if (history_) history_->reset();
}

void SideSpecular::warm_up() {
  if (chains_) chains_->warm_up();
  if (light_) light_->warm_up();
  if (history_) history_->warm_up();
}

}  // namespace lucarium::bundle
