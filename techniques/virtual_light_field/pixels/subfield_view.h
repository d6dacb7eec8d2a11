// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/intersector.h"
#include "lucarium/services/layer_sums/layer_sums.h"
#include "virtual_light_field/field/light_field.h"

namespace lucarium::vlf {

/// A line of the field as a picture, layer `subfield`: what leaves the scene along it, cell by cell.
class SubfieldView {
 public:
  struct Options {
    uint32_t line = 0;  ///< of 0 to 2 n²
    uint32_t width = 0, height = 0;
    float reach = 0;    ///< rays begin at this depth along the line, outside of the scene [m]
    uint32_t seed = 1;  ///< decides BLEND
    bool fold = true;
  };
  /// All must outlive this. `inverse_scale`: one, 1 / LightField::scale().
  SubfieldView(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
               const SurfaceAtlas& atlas, const TypedBuffer<float4>& side_albedo,
               const TypedBuffer<float>& inverse_scale, const LightField& field, const Options& options);
  /// The field as it is.
  void show();
  void write(Film& film) const { sums_.write(film, false); }
  void warm_up() { scheduler_->warm_up(show_); }
  static size_t estimate_bytes(size_t pixels);

 private:
  KernelScheduler* scheduler_;
  LayerSums sums_;
  TypedBuffer<uint32_t> count_;
  Schedule show_;
};

}  // namespace lucarium::vlf
