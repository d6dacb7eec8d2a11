// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/senders/direction_history.h"

#include <algorithm>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"

namespace lucarium::bundle {
namespace {

const char* const kSmaller = "lower texels or glossy_window";

}  // namespace

DirectionHistory::DirectionHistory(Device& device, KernelScheduler& scheduler, const Program& program,
                                   const SceneBuffers& scene, const SurfaceAtlas& atlas, const SideMeans& means,
                                   const std::vector<uint32_t>& sides, const Options& options)
    : scheduler_(&scheduler),
      options_(options),
      count_(static_cast<uint32_t>(sides.size())),
      length_(options.window + options.batch),  // a batch that is begun again needs what came before it
      list_(device, technique_name, "glossy texel sides", sides, kSmaller),
      directions_(device, technique_name, "directions of the history", length_),
      before_(device, technique_name, "received before", size_t{count_} * means.channels().reflected(), kSmaller),
      history_(device, technique_name, "history of glossy texel sides",
               size_t{length_} * count_ * means.channels().reflected(), kSmaller) {
  record(program, scene, atlas, means);
}

size_t DirectionHistory::estimate_bytes(size_t sides, const Channels& channels, const Options& options) {
  return sides *
         (sizeof(uint32_t) + (size_t{options.window} + options.batch + 1) * channels.reflected() * sizeof(float4));
}

void DirectionHistory::record(const Program& program, const SceneBuffers& scene, const SurfaceAtlas& atlas,
                              const SideMeans& means) {
  ScheduleRecorder sending = scheduler_->record("send glossy light", technique_name);
  send_step_ = sending.variable("step", HistoryStep{});
  omega_ = sending.variable("omega", float4{});
  PassBuilder send = surface_pass(sending, "send glossy light", program, "send_history", scene, atlas);
  send.global(count_)
      .arg("count", count_)
      .arg("history_step", send_step_)
      .arg("omega", omega_)
      .arg("directions", directions_)
      .arg("list", list_)
      .arg("history", history_)
      .arg("diffuse", means.diffuse_sent())
      .arg("albedo", means.albedo())
      .arg("records", means.records());
  send_ = sending.compile();
  ScheduleRecorder receiving = scheduler_->record("receive glossy light", technique_name);
  receive_step_ = receiving.variable("step", HistoryStep{});
  receiving.pass("receive glossy light", program, "receive_history")
      .global(count_)
      .arg("count", count_)
      .arg("history_step", receive_step_)
      .arg("list", list_)
      .arg("records", means.records())
      .arg("before", before_)
      .arg("history", history_);
  receive_ = receiving.compile();
}

void DirectionHistory::begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count) {
  batch_.clear();
  for (uint32_t i = 0; i < count; ++i) batch_.emplace_back(sequence.at(first + i).direction, 0.f);
  scheduler_->finish();
  for (uint32_t i = 0; i < count; ++i) directions_.upload({batch_[i]}, (done_ + i) % length_);
}

HistoryStep DirectionHistory::step(uint32_t i) const {
  HistoryStep result{};
  result.index = static_cast<uint32_t>((done_ + i) % length_);
  result.length = length_;
  result.reflected = static_cast<uint32_t>(std::min<uint64_t>(done_ + i, options_.window));
  result.first = i == 0;
  result.by_share = options_.by_share;
  result.by_area = options_.by_area;
  result.adds = options_.adds;
  return result;
}

bool DirectionHistory::send(uint32_t i) {
  send_.set(send_step_, step(i));
  send_.set(omega_, batch_[i]);
  return scheduler_->run(send_) == RunResult::done;
}

void DirectionHistory::receive(uint32_t i) {
  receive_.set(receive_step_, step(i));
  scheduler_->run_to_end(receive_);
}

void DirectionHistory::commit() { done_ += batch_.size(); }

void DirectionHistory::reset() {
  done_ = 0;
  batch_.clear();
}

void DirectionHistory::warm_up() {
  scheduler_->warm_up(send_);
  scheduler_->warm_up(receive_);
}

}  // namespace lucarium::bundle
