// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/pixels/camera_light.h"
#include "bundle_exchange/pixels/side_state.h"

namespace lucarium::bundle {

/// Layers that show what each part of the technique brings (add_light_parts.cl). `sampled_direct` (CameraLight),
/// `exchanged_direct`, `diffuse_exchange`, `specular_chains` and `bundle_gather` sum to the layers `direct` and
/// `indirect`. `accessibility`, `balance` and `direction_history` show what the texel sides behind the pixels hold.
class DebugLayers {
 public:
  /// `preview` may be null, and so may `sides`: then there are no layers of texel sides. The rest must outlive this.
  DebugLayers(Device& device, KernelScheduler& scheduler, const SurfaceAtlas& atlas, const SideMeans& means,
              const SidePreview* preview, const SideState* sides, const CameraLight& camera);

  /// Adds the sample that `camera` has committed last.
  void commit();
  void clear();
  void warm_up();
  /// `smoothed`: the parts of the preview's image.
  void write(Film& film, bool smoothed) const;
  static size_t estimate_bytes(size_t pixels, bool preview) { return pixels * sizeof(float4) * (preview ? 11 : 7); }

 private:
  /// Images of some layers, no part of the image's sum.
  struct Images {
    std::vector<std::string> names;
    std::vector<TypedBuffer<float4>> means;
  };
  Images make_images(Device& device, const std::vector<std::string>& names) const;
  void record_parts(ScheduleRecorder& recorder, const Program& program, const SurfaceAtlas& atlas,
                    const SideHalves& halves, const TypedBuffer<float4>& shown, const TypedBuffer<float4>& shown_direct,
                    const Images& parts) const;
  void record_states(ScheduleRecorder& recorder, const Program& program, Device& device, const SurfaceAtlas& atlas,
                     const SideHalves& halves, const SideState& sides);
  KernelScheduler* scheduler_;
  const CameraLight* camera_;
  Images parts_, smooth_parts_, states_;
  Schedule add_;
  Variable<float> atlas_weight_;
};

}  // namespace lucarium::bundle
