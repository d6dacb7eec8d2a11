// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "virtual_light_field/field/light_field.h"
#include "virtual_light_field/shared/walk_tables.h"

namespace lucarium::vlf {

/// What pixels of a walk need of triangles, materials and light, side by side (shared/walk_tables.h).
class WalkTables {
 public:
  WalkTables() = default;
  /// Empty. All arguments must outlive this. fold: coats below tile_albedo reflect diffusely.
  WalkTables(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const SurfaceAtlas& atlas,
             const LightField& field, const TypedBuffer<float4>& side_albedo, bool fold);

  /// Fills them where they are not those of the light that the field shows now.
  void update();
  void bind(PassBuilder& pass) const;
  void warm_up();
  /// entries: of the field's lists of light.
  static size_t estimate_bytes(size_t triangles, size_t materials, size_t entries);

 private:
  KernelScheduler* scheduler_ = nullptr;
  const LightField* field_ = nullptr;
  TypedBuffer<WalkTriangle> triangles_;
  TypedBuffer<WalkSide> sides_;
  TypedBuffer<WalkLight> light_;
  Schedule list_, list_light_;
  uint32_t sweeps_ = 0;  ///< LightField::shown_sweeps() of light_; 0: all are empty
};

}  // namespace lucarium::vlf
