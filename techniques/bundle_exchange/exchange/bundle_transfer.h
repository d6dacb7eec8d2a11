// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/pixels/pixel_gather.h"
#include "bundle_exchange/senders/side_means.h"
#include "lucarium/services/bundles/bundle_view.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "lucarium/services/texel_sides/side_accessibility.h"

namespace lucarium::bundle {

/// Exchange along all rays of one direction: the scene is drawn orthographically with every fragment. Either
/// consecutive fragments of a pixel give each other what they send (exchange_pairs.cl), or texel sides look themselves
/// up in the bundle image (exchange_texels.cl).
class BundleTransfer {
 public:
  struct Options {
    float pixel_size = 0.5f;  ///< edge of a bundle pixel in texel edges; larger where texels would cover more than 16
    Transfer transfer = Transfer::ray;
    const PixelGather* gather = nullptr;  ///< must outlive this; null: pixels gather nothing
  };
  BundleTransfer(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                 const SurfaceAtlas& atlas, const TypedBuffer<float4>& records, const TexelInterior& interior,
                 const SideAccessibility& accessibility, const Channels& channels, const Options& options);

  /// Adds the rays of one direction to the records, to the end whoever cancels. `seed` decides BLEND.
  void exchange(const BundleDirection& direction, uint32_t seed);
  /// Only the channel of emission.
  void exchange_emission(const BundleDirection& direction, uint32_t seed);
  /// What pixels gather along the direction; `first` of a batch.
  void gather(const BundleDirection& direction, uint32_t seed, bool first);
  void warm_up();
  /// Expected device memory [bytes], with texels of that edge [m].
  static size_t estimate_bytes(const Scene& scene, double texel_edge, const Parameters& parameters, bool gathers);
  double pixel() const { return pixel_; }  ///< edge of bundle pixels [m]
  const LayeredRaster& raster() const { return raster_; }
  /// Largest bundle image of a direction [pixels].
  double largest_image() const { return static_cast<double>(image_edge_) * image_edge_; }
  /// Mean bundle image of the directions until now [pixels]; 0 before the first.
  double mean_image() const { return images_ > 0 ? image_pixels_ / static_cast<double>(images_) : 0.0; }

 private:
  struct Recorded {
    Schedule schedule;
    Variable<LayeredView> view;
    Variable<float4> omega;
    Variable<float> weight;
    Variable<uint32_t> first;
  };
  enum class What { all, emission, gather };
  Recorded record(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                  const TypedBuffer<float4>& records, const TexelInterior& interior,
                  const SideAccessibility& accessibility, What what);
  void run(Recorded& recorded, const BundleDirection& direction, uint32_t seed, bool per_ray);
  KernelScheduler* scheduler_;
  Channels channels_;
  Options options_;
  Bounds bounds_;
  double pixel_;
  uint32_t image_edge_;
  LayeredRaster raster_;
  TypedBuffer<LayeredView> views_;
  TypedBuffer<float4> ends_;
  Recorded all_, emission_, gather_;
  uint64_t images_ = 0;      ///< drawn until now
  double image_pixels_ = 0;  ///< of all of them
};

}  // namespace lucarium::bundle
