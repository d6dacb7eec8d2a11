// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/surface_atlas/layout/layout.h"
#include "lucarium/shared/gbuffer.h"
#include "lucarium/shared/surface_atlas.h"
#include "lucarium/shared/surface_point.h"

namespace lucarium {

struct SurfaceAtlasOptions : AtlasLayoutOptions {
  std::string remedy = "ask for fewer atlas texels";  ///< said where memory is missing
  bool use_texcoord1 = false;  ///< lay out by TEXCOORD_1 the instances that have it; unusable ones are refused
};

/// What was built.
struct SurfaceAtlasReport {
  uint64_t sides = 0;   ///< reflecting sides of texels
  uint64_t texels = 0;  ///< fronts
  uint64_t charts = 0, one_texel_charts = 0;
  uint64_t cells = 0;                              ///< of the look-up table
  double texel_edge = 0;                           ///< s [m]
  double area = 0;                                 ///< of all reflecting sides [m²]
  double area_p5 = 0, area_p50 = 0, area_p95 = 0;  ///< percentiles of texel area over s² [1]
  size_t bytes = 0;                                ///< on the device
  double seconds = 0;                              ///< of building, upload and filling
};

/// Every point of every surface of a scene has a texel, of uniform density in world space. Both sides of double-sided
/// and transmissive surfaces have texel sides of their own; texels never join surfaces that do not touch. Construction
/// and measurements: docs/surface_atlas.md. Look-ups in kernels: kernels/lucarium/surface_atlas.clh.
class SurfaceAtlas {
 public:
  /// Builds and fills the atlas. Refuses with Error{device} and the numbers when it does not fit the device's memory.
  /// `buffers` must outlive this. `owner` pays in the memory account.
  SurfaceAtlas(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
               const SurfaceAtlasOptions& options, const std::string& owner);
  ~SurfaceAtlas();

  /// Follows a change; to be called after buffers.update(). Moved and deformed surfaces keep their texels: positions
  /// follow, areas become Σ fraction × new triangle area. Materials are evaluated again. Changed topology,
  /// materials that became or ceased to be two-sided, and triangles without texels that gain an area, rebuild the
  /// atlas: generation() then grows, and recorded schedules that bind it must be recorded again.
  void refit(const Scene& scene, const SceneChange& change);
  uint64_t generation() const;

  const AtlasInfo& info() const;
  const SurfaceAtlasReport& report() const;
  /// Per world triangle; per cell; per cell (LUCARIUM_ATLAS_LINK bits).
  const TypedBuffer<AtlasTriangle>& triangles() const;
  const TypedBuffer<uint32_t>& table() const;
  const TypedBuffer<uint8_t>& links() const;
  /// Per texel side: sample position and area; the same as a receiver (DirectLight::accumulate_irradiance); what it
  /// scatters and emits; first and number of its pieces.
  const TypedBuffer<AtlasTexel>& texels() const;
  const TypedBuffer<SurfacePoint>& surface_points() const;
  const TypedBuffer<AtlasMaterial>& materials() const;
  const TypedBuffer<uint2>& ranges() const;
  const TypedBuffer<TexelPiece>& pieces() const;
  /// SurfaceAtlasOptions::samples random points per texel side, uniform over its area.
  const TypedBuffer<AtlasSample>& samples() const;
  const std::vector<AtlasChart>& charts() const;

  /// Binds what the kernel has a parameter for: atlas_info (by value), atlas_triangles, atlas_table, atlas_links,
  /// atlas_texels, atlas_points, atlas_materials, atlas_ranges, atlas_pieces, atlas_samples.
  void bind(PassBuilder& pass) const;

  /// Compiles what refit() will launch.
  void warm_up();

  /// Adds the layer `atlas` to a film: the texel that each pixel of a G-buffer shows, its id hashed to a colour.
  void resolve(const TypedBuffer<GBufferPoint>& points, Film& film) const;

  /// The colours of that layer, per side.
  std::vector<float4> side_colors() const;

  /// Expected edge s of texels [m].
  static double estimate_edge(const Scene& scene, const AtlasLayoutOptions& options);
  /// Most texel sides that an atlas of the scene has: surfaces that touch nothing have a texel each, whatever was
  /// wanted.
  static size_t estimate_sides(const Scene& scene, const AtlasLayoutOptions& options);
  /// How many it is likely to have.
  static size_t expected_sides(const Scene& scene, const AtlasLayoutOptions& options);
  /// Of the sides that it covers [m²].
  static double side_area(const Scene& scene);
  /// Device memory for as many texel sides [bytes], by default the most; the constructor states the exact one.
  static size_t estimate_bytes(const Scene& scene, const AtlasLayoutOptions& options, size_t sides);
  static size_t estimate_bytes(const Scene& scene, const AtlasLayoutOptions& options) {
    return estimate_bytes(scene, options, estimate_sides(scene, options));
  }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
