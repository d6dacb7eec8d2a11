// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "bundle_exchange/pixels/pixel_gather.h"
#include "bundle_exchange/senders/side_preview.h"
#include "bundle_exchange/specular/chain_tracer.h"
#include "lucarium/services/eye_light/eye_light.h"
#include "lucarium/services/layer_spread/layer_spread.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// What depends on the camera: the points it sees, their emission, direct light by samples, and the atlas' light
/// reflected at full resolution; specular lobes, or all, by chains that begin at the pixels. One sample per pixel and
/// iteration.
class CameraLight {
 public:
  struct Options {
    FinalGather gather = FinalGather::off;
    bool punctual = false;   ///< there are punctual lights
    bool single = false;     ///< chains end behind their first vertex
    bool exchanged = false;  ///< bundles carry emitted light: light samples are of punctual lights only
    int max_bounces = -1;
    bool by_bundles = false;  ///< rays of `gather` are those of bundles, except for lobes below min_alpha
    float min_alpha = 0;
    bool debug = false;  ///< with the layer `sampled_direct` (DebugLayers)
  };
  /// `preview` (may be null) must outlive this: commit() shows what it has smoothed in an image of its own.
  CameraLight(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
              const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
              const SidePreview* preview, const Frame& frame, const Options& options);

  /// The next sample, in two steps, between which bundles may gather for its points (pixel_gather()); false when
  /// cancelled. commit() then adds it, looking up the atlas as it is then; what the atlas said while it knew nothing is
  /// forgotten. `measured`: how far it lies from those before counts for spread().
  bool begin_sample();
  bool sample();
  void commit(bool atlas_known, bool measured);
  void reset(uint32_t seed);
  void set_frame(const Frame& frame);
  bool fits(const Frame& frame) const { return frame.width == frame_.width && frame.height == frame_.height; }
  void warm_up();
  const LayerSpread& spread() const { return *spread_; }
  uint32_t samples() const { return samples_; }
  uint32_t atlas_samples() const { return atlas_samples_; }  ///< of them, in the mean of what the atlas says
  /// `smoothed`: the image of the preview.
  void resolve(Film& film, bool smoothed) const;
  /// Of the last sample: its points, what chains and bundles have gathered for them (scattered once, and more often),
  /// and what it counts of the mean of what the atlas says.
  const TypedBuffer<GBufferPoint>& points() const { return eye_.points(); }
  const TypedBuffer<float4>& gathered() const { return chains_ ? chains_->contribution() : no_contributions_; }
  const TypedBuffer<float4>& bundled() const { return bundles_ ? bundles_->gathered() : no_contributions_; }
  float atlas_weight() const;
  uint32_t pixels() const { return pixels_; }
  bool whole() const { return options_.gather == FinalGather::all; }  ///< nothing is looked up at pixels
  PixelGather* pixel_gather() { return bundles_.get(); }              ///< null where bundles gather nothing
  /// Mean over the samples that commit() has added.
  double rays_per_sample() const { return samples_ > 0 ? static_cast<double>(committed_rays_) / samples_ : 0; }
  uint64_t rays() const { return chains_ ? chains_->chains().rays() : 0; }
  static size_t estimate_bytes(uint32_t width, uint32_t height, FinalGather gather, bool by_bundles, bool preview);

 private:
  void record(Device& device, const Program& program, const SurfaceAtlas& atlas, const SideMeans& means,
              const SidePreview* preview);
  /// What the atlas knows, mixed into an image; `deviates`: for spread(), too.
  void record_atlas_light(ScheduleRecorder& recorder, const Program& program, const SurfaceAtlas& atlas,
                          const SideHalves& halves, const TypedBuffer<float4>& shown,
                          const TypedBuffer<float4>& shown_direct, const LayerSums& image, bool deviates);
  void record_chains(const Program& program, const SceneBuffers& scene);
  bool gather();
  KernelScheduler* scheduler_;
  Options options_;
  Frame frame_;
  uint32_t pixels_, samples_ = 0, atlas_samples_ = 0;
  uint64_t sample_rays_ = 0, committed_rays_ = 0;  ///< of chains: of the last sample, of all that were added
  EyeLight eye_;
  LayerSums atlas_light_;   ///< means: `direct`, where bundles bring it, and `indirect`
  LayerSums smooth_light_;  ///< the same by what the preview shows
  TypedBuffer<float4> no_contributions_;
  std::unique_ptr<ChainTracer> chains_;  ///< null where nothing is gathered
  std::unique_ptr<PixelGather> bundles_;
  Schedule begin_, add_;
  Variable<ChainSettings> settings_;
  Variable<float> atlas_weight_;
  Variable<uint32_t> atlas_samples_before_;
  std::unique_ptr<LayerSpread> spread_;  ///< of samples of pixels, in the light that the atlas has
};

}  // namespace lucarium::bundle
