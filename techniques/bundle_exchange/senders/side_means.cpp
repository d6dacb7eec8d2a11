// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/senders/side_means.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "bundle_exchange/base/name.h"
#include "bundle_exchange/shared/balance.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/technique/technique_state.h"

namespace lucarium::bundle {
namespace {

constexpr uint64_t kKeptBatches = 16;   // that what was known before a change counts for at most
constexpr uint64_t kErrorBatches = 16;  // between two measurements of the error
constexpr double kIndirectPart =
    0.7071;  // of the wanted error: half of its variance, the other half is for direct light
constexpr double kUnknown = std::numeric_limits<double>::infinity();

}  // namespace

std::map<std::string, std::string> Channels::defines() const {
  std::map<std::string, std::string> result{{"BUNDLE_CHANNELS", std::to_string(count) + "u"}};
  if (emission) result["BUNDLE_EMISSION"] = "";
  if (exchanged()) result["BUNDLE_EXCHANGED"] = "";
  if (self_fed) result["BUNDLE_SELF_FED"] = "";
  if (chains) result["BUNDLE_CHAINS"] = "";
  return result;
}

SideMeans::SideMeans(Device& device, KernelScheduler& scheduler, const Program& program, const SurfaceAtlas& atlas,
                     const SideAccessibility& accessibility, const TypedBuffer<float4>& light_samples,
                     const Channels& channels, const Parameters& parameters)
    : scheduler_(&scheduler),
      primitives_(device),
      channels_(channels),
      parameters_(parameters),
      halves_(accessibility.side_halves()),
      sides_(halves_.count),
      chunks_((sides_ + BALANCE_CHUNK - 1) / BALANCE_CHUNK),
      light_samples_(light_samples),
      accessibility_(accessibility.shares()),
      albedo_(device, technique_name, "albedo of texel sides", sides_, remedies::lower_texels),
      emission_(device, technique_name, "emission of texel sides", sides_, remedies::lower_texels),
      records_(device, technique_name, "exchange records", size_t{sides_} * 2 * channels.count, remedies::lower_texels),
      senders_(device, technique_name, "sender means", size_t{sides_} * channels.reflected(), remedies::lower_texels),
      display_(device, technique_name, "display means", size_t{sides_} * channels.count, remedies::lower_texels),
      finished_(device, technique_name, "finished bounces", one_by_one() ? sides_ : 1, remedies::lower_texels),
      statistics_(device, technique_name, "batch statistics", size_t{sides_} * (channels.exchanged() ? 2 : 1),
                  remedies::lower_texels),
      shown_(device, technique_name, "displayed texel sides", sides_, remedies::lower_texels),
      shown_direct_(device, technique_name, "displayed direct light", channels.exchanged() ? sides_ : 1,
                    remedies::lower_texels),
      diffuse_(device, technique_name, "diffuse senders", channels.chains ? size_t{sides_} * channels.reflected() : 1,
               remedies::lower_texels),
      radiance_(device, technique_name, "diffuse radiance", diffuse_.count(), remedies::lower_texels),
      chunk_sums_(device, technique_name, "balance of chunks", 2 * size_t{chunks_}),
      scale_(device, technique_name, "sender scale", std::vector<float4>{{1, 1, 1, 0}}),
      specular_(device, technique_name, "light of specular lobes", 1),
      visible_(device, technique_name, "visible shares", sides_, remedies::lower_texels),
      errors_(device, technique_name, "errors of texel sides", sides_, remedies::lower_texels),
      indirect_errors_(device, technique_name, "errors of texel sides' indirect light", sides_, remedies::lower_texels),
      values_(device, technique_name, "values of texel sides", sides_, remedies::lower_texels),
      sums_(device, technique_name, "sums of errors and values", 3) {
  record_materials(program, atlas);
  record_senders(program);
  record_accumulation(program);
  record_errors(program);
  reset();
}

size_t SideMeans::estimate_bytes(size_t sides, const Channels& channels, const Parameters& parameters) {
  const size_t float4s = 2 * channels.count + channels.reflected() + channels.count + 4 +
                         (bounces_one_by_one(channels, parameters) ? 1 : 0) + (channels.exchanged() ? 2 : 0) +
                         (channels.chains ? 2 * channels.reflected() : 0);
  return sides * (float4s * sizeof(float4) + sizeof(float2) + 3 * sizeof(float));
}

void SideMeans::record_materials(const Program& program, const SurfaceAtlas& atlas) {
  ScheduleRecorder recorder = scheduler_->record("texel side materials", technique_name);
  PassBuilder pass = recorder.pass("copy materials", program, "copy_materials");
  atlas.bind(pass);
  pass.global(sides_).arg("half_count", sides_).arg("accessibility", accessibility_);
  pass.arg("albedo", albedo_).arg("emission", emission_);
  materials_ = recorder.compile();
}

void SideMeans::record_senders(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("senders", technique_name);
  direct_share_ = recorder.variable("direct share", 1.f);
  feedback_share_ = recorder.variable("feedback share", 1.f);
  if (balanced()) {
    recorder.pass("balance of chunks", program, "balance_chunks")
        .global(chunks_)
        .local(1)
        .arg("sides", sides_)
        .arg("albedo", albedo_)
        .arg("light_samples", light_samples_)
        .arg("senders", senders_)
        .arg("display", display_)
        .arg("visible", visible_)
        .arg("chunks", chunk_sums_);
    recorder.pass("balance", program, "balance_scale")
        .global(1)
        .local(1)
        .arg("count", chunks_)
        .arg("chunks", chunk_sums_)
        .arg("specular", specular_)
        .arg("scale", scale_);
  }
  recorder.pass("make senders", program, "make_senders")
      .global(sides_)
      .arg("sides", sides_)
      .arg("albedo", albedo_)
      .arg("emission", emission_)
      .arg("light_samples", light_samples_)
      .arg("senders", senders_)
      .arg("display", display_)
      .arg("scale", scale_)
      .arg("direct_share", direct_share_)
      .arg("feedback_share", feedback_share_)
      .arg("diffuse", diffuse_)
      .arg("records", records_);
  make_senders_ = recorder.compile();
}

void SideMeans::record_accumulation(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("accumulate batch", technique_name);
  sender_scale_ = recorder.variable("sender scale", 1.f);
  sender_weight_ = recorder.variable("sender weight", 1.f);
  display_weight_ = recorder.variable("display weight", 1.f);
  show_share_ = recorder.variable("share shown", 1.f);
  if (balanced() && channels_.chains) {
    recorder.pass("light of specular lobes", program, "specular_chunks")
        .global(chunks_)
        .local(1)
        .arg("sides", sides_)
        .arg("diffuse", diffuse_)
        .arg("records", records_)
        .arg("chunks", chunk_sums_);
    recorder.pass("sum of specular light", program, "specular_sum")
        .global(1)
        .local(1)
        .arg("count", chunks_)
        .arg("sender_scale", sender_scale_)
        .arg("sender_weight", sender_weight_)
        .arg("chunks", chunk_sums_)
        .arg("specular", specular_);
  }
  recorder.pass("accumulate batch", program, "accumulate_batch")
      .global(sides_)
      .arg("sides", sides_)
      .arg("sender_scale", sender_scale_)
      .arg("sender_weight", sender_weight_)
      .arg("display_weight", display_weight_)
      .arg("records", records_)
      .arg("senders", senders_)
      .arg("display", display_)
      .arg("visible", visible_)
      .arg("statistics", statistics_);
  recorder.pass("make display", program, "make_display")
      .global(sides_)
      .arg("sides", sides_)
      .arg("share", show_share_)
      .arg("accessibility", accessibility_)
      .arg("albedo", albedo_)
      .arg("light_samples", light_samples_)
      .arg("one_by_one", one_by_one() ? 1u : 0u)
      .arg("finished", finished_)
      .arg("display", display_)
      .arg("shown", shown_)
      .arg("shown_direct", shown_direct_)
      .arg("radiance", radiance_)
      .discards("shown");
  accumulate_ = recorder.compile();
  if (!one_by_one()) return;
  ScheduleRecorder finish = scheduler_->record("finish bounce", technique_name);
  finish.pass("finish bounce", program, "finish_bounce")
      .global(sides_)
      .arg("sides", sides_)
      .arg("display", display_)
      .arg("senders", senders_)
      .arg("finished", finished_);
  finish_bounce_ = finish.compile();
}

void SideMeans::record_errors(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("measure error", technique_name);
  const BufferRef error = recorder.transient<float>("error", 1), value = recorder.transient<float>("value", 1);
  const BufferRef indirect_error = recorder.transient<float>("error of indirect light", 1);
  recorder.pass("errors of texel sides", program, "measure_errors")
      .global(sides_)
      .arg("sides", sides_)
      .arg("albedo", albedo_)
      .arg("display", display_)
      .arg("statistics", statistics_)
      .arg("errors", errors_)
      .arg("indirect_errors", indirect_errors_)
      .arg("values", values_);
  primitives_.record_reduce(recorder, "sum of errors", Primitives::Reduction::sum_float, errors_, error, sides_);
  primitives_.record_reduce(recorder, "sum of indirect errors", Primitives::Reduction::sum_float, indirect_errors_,
                            indirect_error, sides_);
  primitives_.record_reduce(recorder, "sum of values", Primitives::Reduction::sum_float, values_, value, sides_);
  recorder.pass("copy sums", program, "copy_sums")
      .global(1)
      .local(1)
      .arg("error", error)
      .arg("indirect_error", indirect_error)
      .arg("value", value)
      .arg("sums", sums_);
  recorder.read_back("error", sums_, [this](std::span<const std::byte> bytes) {
    float sums[3];
    std::memcpy(sums, bytes.data(), sizeof sums);
    const bool met = sums[2] > 0;  // nothing met yet is no accuracy
    relative_error_ = met ? sums[0] / sums[2] : kUnknown;
    indirect_error_ = met ? sums[1] / sums[2] : kUnknown;
  });
  measure_ = recorder.compile();
}

bool SideMeans::balanced() const {
  // Texels that look themselves up meet in no pairs, by which the light of specular lobes is measured.
  const bool measurable = !channels_.chains || parameters_.transfer == Transfer::ray;
  return channels_.self_fed && parameters_.balance && parameters_.interleave == Interleave::sd && measurable;
}

uint64_t SideMeans::reflecting(uint64_t directions) const {
  if (channels_.reflected() == 0) return 0;
  const uint64_t head = channels_.exchanged() ? static_cast<uint64_t>(parameters_.direct_first) : 0;
  const uint64_t done = std::min(directions, reflected_end_);
  return done - std::min(done, head);
}

double SideMeans::fixed_share() const {
  const uint64_t total = std::max<uint64_t>(1, reflecting(direction_limit(parameters_)));
  return static_cast<double>(reflecting(directions_)) / static_cast<double>(total);
}

void SideMeans::set_shares() {
  double feedback = one_by_one() && sends_direct() ? 0 : 1;  // later bounces send what the one before has brought
  if (parameters_.interleave == Interleave::fixed) feedback = fixed_share();
  make_senders_.set(direct_share_, sends_direct() ? 1.f : 0.f);
  make_senders_.set(feedback_share_, static_cast<float>(feedback));
}

void SideMeans::copy_materials() { scheduler_->run_to_end(materials_); }

bool SideMeans::make_senders() {
  set_shares();
  return scheduler_->run(make_senders_) == RunResult::done;
}

// The first directions, which carry direct light alone (Hermes et al. 2010, section 6.4: 8 at first, or 1700 of 2000),
// and the last ones, since direct light converges more slowly.
bool SideMeans::direct_only(uint64_t first) const {
  return channels_.exchanged() &&
         (first < uint64_t(parameters_.direct_first) || first >= reflected_end_ || channels_.reflected() == 0);
}

bool SideMeans::carries_all(uint64_t directions) const {
  return !direct_only(directions) || directions >= reflected_end_ || channels_.reflected() == 0;
}

void SideMeans::commit(uint64_t first, uint32_t count) {
  SenderWeights::Step step = weights_.next(reflecting(first), count);
  const bool without_reflection = direct_only(first), head = !carries_all(first);
  directions_ = first + count;
  if (one_by_one()) step.sender_weight = 0;
  if (without_reflection) step = {1, 0, 0};
  accumulate_.set(sender_scale_, static_cast<float>(step.sender_scale));
  accumulate_.set(sender_weight_, static_cast<float>(step.sender_weight));
  accumulate_.set(display_weight_, static_cast<float>(step.display_weight));
  accumulate_.set(show_share_, parameters_.interleave == Interleave::fixed ? static_cast<float>(fixed_share()) : 1.f);
  scheduler_->run_to_end(accumulate_);
  ++batches_;
  if (!without_reflection) weights_.advance();
  if (one_by_one() && !without_reflection && reflecting(directions_) % uint64_t(parameters_.block) == 0)
    scheduler_->run_to_end(finish_bounce_);
  if (head) head_batches_ = batches_;
  if (batches_ > head_batches_ && (batches_ - head_batches_) % kErrorBatches == 0) measure_errors();
}

void SideMeans::measure_errors() {
  scheduler_->run_to_end(measure_);
  scheduler_->finish();
  measured_ = reflecting(directions_);
  if (!channels_.exchanged() || channels_.reflected() == 0 || !forgets(parameters_) || directions_ >= reflected_end_)
    return;
  if (indirect_error_ < kIndirectPart * static_cast<double>(parameters_.stop_error)) reflected_end_ = directions_;
}

void SideMeans::reset() {
  weights_ = SenderWeights(parameters_);
  for (Buffer* buffer : std::initializer_list<Buffer*>{&senders_, &display_, &finished_, &shown_, &shown_direct_,
                                                       &radiance_, &visible_, &specular_, &statistics_})
    buffer->fill_zero();
  scale_.upload({{1, 1, 1, 0}});
  directions_ = batches_ = head_batches_ = 0;
  reflected_end_ = UINT64_MAX;
  relative_error_ = indirect_error_ = kUnknown;
  measured_ = 0;
}

SideMeans::Kept SideMeans::keep() const {
  scheduler_->finish();
  return {senders_.download(), specular_.download(), weights_, sides_, channels_};
}

bool SideMeans::start_from(Kept kept) {
  if (kept.half_count != sides_ || !(kept.channels == channels_) || kept.weights.batches() == 0) return false;
  const float share = static_cast<float>(kept.weights.forget(kKeptBatches));
  for (float4& sums : kept.senders) sums = float4(sums.x * share, sums.y * share, sums.z * share, sums.w * share);
  senders_.upload(kept.senders);
  specular_.upload(kept.specular);
  weights_ = kept.weights;
  return true;
}

void SideMeans::save(StateWriter& chunks) const {
  chunks.put("shown", shown_);
  chunks.put("shown_direct", shown_direct_);
  chunks.put("radiance", radiance_);
  if (halves_.two()) chunks.put("covered", halves_.covered);
  chunks.put("progress", std::vector<uint64_t>{directions_, batches_, head_batches_, reflected_end_});
  chunks.put("errors", std::vector<double>{relative_error_, indirect_error_});
}

void SideMeans::load(const StateReader& chunks) {
  constexpr double any = std::numeric_limits<float>::max();
  chunks.get_light_buffer("shown", shown_, any);
  chunks.get_light_buffer("shown_direct", shown_direct_, any);
  chunks.get_light_buffer("radiance", radiance_, any);
  if (halves_.two()) chunks.get_buffer("covered", halves_.covered);
  const std::vector<uint64_t> progress = chunks.get<uint64_t>("progress", 4);
  directions_ = progress[0], batches_ = progress[1], head_batches_ = progress[2], reflected_end_ = progress[3];
  const std::vector<double> errors = chunks.get<double>("errors", 2);
  relative_error_ = errors[0], indirect_error_ = errors[1];
  measured_ = reflecting(directions_);
  if (std::isnan(relative_error_) || std::isnan(indirect_error_)) chunks.fail("errors", "an error is not a number");
}

void SideMeans::warm_up() {
  for (Schedule* schedule : {&materials_, &make_senders_, &accumulate_, &measure_}) scheduler_->warm_up(*schedule);
  if (one_by_one()) scheduler_->warm_up(finish_bounce_);
}

}  // namespace lucarium::bundle
