// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "bundle_exchange/senders/sender_weights.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/services/texel_sides/side_accessibility.h"

namespace lucarium {
class StateReader;
class StateWriter;
}  // namespace lucarium

namespace lucarium::bundle {

/// What travels along the rays at once (exchange_layout.clh).
struct Channels {
  bool emission = false;    ///< channel 0 carries emitted light
  bool to_history = false;  ///< for direction histories of glossy texel sides alone: direct light comes from elsewhere
  bool chains = false;      ///< chains of specular vertices are followed
  bool self_fed = true;     ///< one channel of reflected light, all bounces; else one per bounce
  uint32_t count = 1;       ///< all channels
  bool operator==(const Channels&) const = default;
  bool exchanged() const { return emission && !to_history; }  ///< bundles bring direct light
  uint32_t reflected() const { return count - (emission ? 1 : 0); }
  /// Preprocessor definitions for the kernels.
  std::map<std::string, std::string> defines() const;
};

/// What every texel side has received so far, and what it sends: the two growing means S and D, the balance between
/// them, their error, and what is displayed.
class SideMeans {
 public:
  SideMeans(Device& device, KernelScheduler& scheduler, const Program& program, const SurfaceAtlas& atlas,
            const SideAccessibility& accessibility, const TypedBuffer<float4>& light_samples, const Channels& channels,
            const Parameters& parameters);

  /// Takes albedo, emission and area of texel sides from the atlas; before anything else, when accessibility is known.
  void copy_materials();
  /// Prepares the records of the next batch; false when cancelled.
  bool make_senders();
  /// How many of the first `directions` carry reflected light: those behind direct_first, until that light is known
  /// well.
  uint64_t reflecting(uint64_t directions) const;
  /// Whether the batch that begins with direction `first` carries emission only: before or behind those.
  bool direct_only(uint64_t first) const;
  /// Whether direct light is sent: of bounces that are computed one by one only the first does.
  bool sends_direct() const {
    return !one_by_one() || reflecting(directions_) < static_cast<uint64_t>(parameters_.block);
  }
  /// Whether every kind of light has begun to travel after so many directions, so that the error speaks of the image.
  bool carries_all(uint64_t directions) const;
  /// Adds the records of a batch of `count` directions, of which `first` came before, and renews what is displayed.
  void commit(uint64_t first, uint32_t count);
  void reset();
  void warm_up();

  /// What senders know, for a start in a scene that has changed little: it counts as a few batches.
  struct Kept {
    std::vector<float4> senders, specular;
    SenderWeights weights;
    uint32_t half_count = 0;
    Channels channels;
  };
  Kept keep() const;
  /// After reset(). False where it does not fit: nothing has changed then.
  bool start_from(Kept kept);

  /// What is displayed, and how far it has come, for a file; and back, after reset().
  void save(StateWriter& chunks) const;
  void load(const StateReader& chunks);
  uint64_t directions() const { return directions_; }  ///< of all batches

  // Per texel side, of its halves (SideAccessibility::halves()):
  const SideHalves& halves() const { return halves_; }
  const TypedBuffer<float4>& records() const { return records_; }  ///< 2 · channels float4 (exchange_layout.clh)
  const TypedBuffer<float4>& albedo() const { return albedo_; }    ///< xyz diffuse albedo, w area times accessibility
  /// Irradiance / π of indirect light times accessibility, and that; the same of exchanged emitted light.
  const TypedBuffer<float4>& shown() const { return shown_; }
  const TypedBuffer<float4>& shown_direct() const { return shown_direct_; }
  /// What is reflected diffusely (Channels::chains), reflected() float4: in the batch, and by the best means.
  const TypedBuffer<float4>& diffuse_sent() const { return diffuse_; }
  const TypedBuffer<float4>& diffuse_shown() const { return radiance_; }
  const TypedBuffer<float4>& senders() const { return senders_; }  ///< S, reflected() channels one after the other
  const TypedBuffer<float4>& scale() const { return scale_; }      ///< one: xyz what the balance scales senders by
  const Channels& channels() const { return channels_; }
  /// Of batches, per texel side, for its error, those of exchanged emitted light behind the others
  /// (accumulate_batch.cl); and how many batches there were.
  const TypedBuffer<float4>& statistics() const { return statistics_; }
  uint64_t batches() const { return batches_; }
  /// Relative standard error of the displayed irradiance, area-weighted; infinity before 16 batches of all the light.
  double relative_error() const { return relative_error_; }
  /// Relative variance of what a direction brings of reflected light: the square of the error of that alone times the
  /// directions, both when it was measured last. Where light is uneven this is too small: errors are averaged first.
  double direction_variance() const { return indirect_error_ * indirect_error_ * static_cast<double>(measured_); }
  /// Whether reflected light is known well enough (of the wanted error it makes up half of the variance at most), and
  /// only emission is exchanged further, which takes longer.
  bool reflected_light_done() const { return directions_ >= reflected_end_; }
  /// What the balance scales senders by, per colour.
  float4 balance() const { return scale_.download().front(); }
  /// For so many halves of texel sides.
  static size_t estimate_bytes(size_t sides, const Channels& channels, const Parameters& parameters);

 private:
  void record_materials(const Program& program, const SurfaceAtlas& atlas);
  void record_senders(const Program& program);
  void record_accumulation(const Program& program);
  void record_errors(const Program& program);
  /// Bounces are computed one after the other.
  bool one_by_one() const { return bounces_one_by_one(channels_, parameters_); }
  static bool bounces_one_by_one(const Channels& channels, const Parameters& parameters) {
    return parameters.interleave == Interleave::pingpong && channels.self_fed;
  }
  /// Senders are scaled by the balance of power.
  bool balanced() const;
  void set_shares();
  /// Of all directions that are to carry reflected light, the share that is done.
  double fixed_share() const;
  void measure_errors();
  KernelScheduler* scheduler_;
  Primitives primitives_;
  Channels channels_;
  Parameters parameters_;
  SideHalves halves_;
  uint32_t sides_, chunks_;  ///< halves of all texel sides, as kernels count them; chunks of them
  TypedBuffer<float4> light_samples_;
  TypedBuffer<float> accessibility_;
  TypedBuffer<float4> albedo_, emission_, records_;
  TypedBuffer<float4> senders_, display_, finished_;  ///< S, D, bounces that are done (pingpong)
  TypedBuffer<float4> statistics_;
  TypedBuffer<float4> shown_, shown_direct_;
  TypedBuffer<float4> diffuse_, radiance_;             ///< of chains' ends
  TypedBuffer<float4> chunk_sums_, scale_, specular_;  ///< of the balance
  TypedBuffer<float2> visible_;
  TypedBuffer<float> errors_, indirect_errors_, values_, sums_;
  Schedule materials_, make_senders_, accumulate_, finish_bounce_, measure_;
  Variable<float> direct_share_, feedback_share_, sender_scale_, sender_weight_, display_weight_, show_share_;
  SenderWeights weights_;
  uint64_t directions_ = 0, batches_ = 0;
  uint64_t head_batches_ = 0;            ///< of them, those of direct_first
  uint64_t reflected_end_ = UINT64_MAX;  ///< directions after which only emission travels
  double relative_error_, indirect_error_;
  uint64_t measured_ = 0;  ///< directions with reflected light when the errors were measured
};

}  // namespace lucarium::bundle
