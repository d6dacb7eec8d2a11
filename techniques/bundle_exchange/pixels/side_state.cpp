// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/pixels/side_state.h"

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/late_weight.h"
#include "bundle_exchange/base/name.h"

namespace lucarium::bundle {
SideState::SideState(Device& device, KernelScheduler& scheduler, const SideMeans& means,
                     const TypedBuffer<float>& shares, const SideSpecular* specular)
    : scheduler_(&scheduler),
      accessibility_(&shares),
      has_history_(specular && specular->has_history()),
      balance_(device, technique_name, "balance of texel sides", shares.count(), no_debug_layers),
      history_(device, technique_name, "light of direction histories", shares.count(), no_debug_layers),
      no_light_(device, technique_name, "no light samples", 1) {
  const Program program = make_bundle_program(device, "pixels/mix_side_state", means.channels().defines());
  ScheduleRecorder balance = scheduler.record("add balance of texel sides", technique_name);
  batch_weight_ = balance.variable("weight", 1.f);
  balance.pass("mix balance", program, "mix_balance")
      .global(shares.count())
      .arg("sides", static_cast<uint32_t>(shares.count()))
      .arg("weight", batch_weight_)
      .arg("albedo", means.albedo())
      .arg("senders", means.senders())
      .arg("scale", means.scale())
      .arg("balance", balance_);
  add_balance_ = balance.compile();
  if (has_history_) {
    const TypedBuffer<float4>* light = specular->history_light();
    ScheduleRecorder history = scheduler.record("add light of direction histories", technique_name);
    direction_weight_ = history.variable("weight", 1.f);
    history.pass("mix history", program, "mix_history")
        .global(specular->history_sides().count())
        .arg("count", static_cast<uint32_t>(specular->history_sides().count()))
        .arg("weight", direction_weight_)
        .arg("list", specular->history_sides())
        .arg("records", means.records())
        .arg("diffuse", means.diffuse_sent())
        .arg("lit", light ? specular->lit_sides() : 0u)
        .arg("light", light ? *light : no_light_)
        .arg("history", history_);
    add_history_ = history.compile();
  }
  reset();
}

void SideState::add_balance() {
  add_balance_.set(batch_weight_, late_weight(++batches_));
  scheduler_->run_to_end(add_balance_);
}

void SideState::add_history() {
  if (!has_history_) return;
  add_history_.set(direction_weight_, late_weight(++directions_));
  scheduler_->run_to_end(add_history_);
}

void SideState::reset() {
  for (TypedBuffer<float4>* mean : {&balance_, &history_}) mean->fill_zero();
  batches_ = directions_ = 0;
}

void SideState::warm_up() {
  scheduler_->warm_up(add_balance_);
  if (has_history_) scheduler_->warm_up(add_history_);
}

}  // namespace lucarium::bundle
