// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/services/eye_light/eye_light.h"
#include "lucarium/services/gbuffer/camera_rays.h"
#include "lucarium/services/specular_chains/specular_chains.h"
#include "virtual_light_field/base/parameters.h"
#include "virtual_light_field/base/plan.h"
#include "virtual_light_field/field/light_field.h"
#include "virtual_light_field/pixels/subfield_view.h"
#include "virtual_light_field/pixels/walk_tables.h"

namespace lucarium::vlf {

/// What the camera sees: emission and direct light by samples, or by the atlas, and the field, looked up at pixels or
/// where a ray by their specular lobes ends. One sample per pixel and iteration.
class FieldView {
 public:
  struct Options {
    uint32_t eye_kinds = 0;      ///< of light samples; 0: the atlas has direct light
    bool lobes = false;          ///< specular lobes are looked up at pixels
    bool first_surface = false;  ///< mirrors and glass, where there are some, are looked up at pixels
    bool traced = false;         ///< rays follow them
    /// Pixels show the first surface's emission and look-ups alone.
    bool walks() const { return eye_kinds == 0 && first_surface && !traced; }
    bool nearest = false;  ///< eye_interp
    bool fold = true;
    int max_bounces = -1;
    int inspect_line = -1;  ///< shown as layer `subfield`; -1: none
    float reach = 0;        ///< SubfieldView::Options::reach
  };
  /// `field` may be null, and atlas and patches with it: direct light alone. All must outlive this.
  FieldView(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
            const SurfaceAtlas* atlas, const Patches* patches, const LightField* field, const Frame& frame,
            const Options& options);

  /// The next sample, false when cancelled; commit() then adds it.
  bool sample();
  void commit();
  void reset(uint32_t seed);
  void set_frame(const Frame& frame);
  bool fits(const Frame& frame) const { return frame.width == frame_.width && frame.height == frame_.height; }
  void warm_up();
  uint32_t samples() const { return samples_; }
  uint32_t shown_sweeps() const { return shown_sweeps_; }    ///< of the field, that the last sample shows
  uint32_t field_samples() const { return field_samples_; }  ///< of them, those that show the field as it is
  uint64_t rays() const { return chains_ ? chains_->rays() : 0; }
  void resolve(Film& film) const;
  /// All but `reach`.
  static Options make_options(const Plan& plan, const Parameters& parameters);
  /// Without WalkTables.
  static size_t estimate_bytes(uint32_t width, uint32_t height, const Options& options);

 private:
  void record_field(const SceneBuffers& scene, const SurfaceAtlas& atlas);
  void bind_shown(PassBuilder& pass, const SurfaceAtlas& atlas) const;
  void make_chains(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                   const SurfaceAtlas& atlas);
  void bind_lookups(PassBuilder& pass, const SurfaceAtlas& atlas) const;
  bool shows_field() const;
  void keep_scale();  ///< on the device, too

  KernelScheduler* scheduler_;
  const LightField* field_;
  Options options_;
  Frame frame_;
  uint32_t pixels_, samples_ = 0, field_samples_ = 0, shown_sweeps_ = 0;
  std::unique_ptr<EyeLight> eye_;     ///< null where pixels walk
  std::unique_ptr<CameraRays> rays_;  ///< null where they do not, and tables_ with them
  std::unique_ptr<WalkTables> tables_;
  LayerSums sums_;  ///< means of what the field shows; where pixels walk, of emission, too
  TypedBuffer<float4> traced_, side_albedo_;
  std::unique_ptr<SpecularChains> chains_;  ///< null where no ray is sent
  std::unique_ptr<SubfieldView> subfield_;  ///< null where no line is shown
  Schedule begin_, show_;
  Variable<uint32_t> shows_, begins_;
  Variable<ChainSettings> settings_;
  Variable<float> weight_;
  TypedBuffer<float> scale_;  ///< one: 1 / LightField::scale()
  float kept_scale_ = 0;      ///< of which it is; 0: of none
};

}  // namespace lucarium::vlf
