// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "bundle_exchange/bundle_plan.h"
#include "bundle_exchange/cost.h"
#include "bundle_exchange/exchange/bundle_transfer.h"
#include "bundle_exchange/pixels/debug_layers.h"
#include "bundle_exchange/specular/side_specular.h"
#include "lucarium/services/texel_sides/side_light.h"

namespace lucarium::bundle {

/// Everything that is made for one scene, in the order of dependence.
struct BundleParts {
  /// Parts that may outlast a change of the scene, or null: the atlas, and interior and accessibility of its texels.
  struct Kept {
    std::unique_ptr<SurfaceAtlas> atlas;
    std::unique_ptr<TexelInterior> interior;
    std::unique_ptr<SideAccessibility> accessibility;
  };

  BundleParts(const TechniqueContext& c, const Parameters& p, const BundlePlan& plan, Kept kept);
  /// Measures hidden parts and accessibility of texels. `report`: as TechniqueContext::progress. Throws
  /// Error{interrupted} when cancelled.
  void measure_accessibility(const std::function<void(double, const std::string&)>& report);
  /// Adds the camera sample. `atlas_known` as for CameraLight::commit().
  void commit_sample(bool atlas_known);
  WorkUnits work_units(const Scene& scene) const;
  /// Share of the work that lowers the error of the image most when it goes to samples of pixels: given, or by the
  /// variances of these and of a direction, measured so far.
  EyeShare eye_share(const Parameters& parameters, const WorkUnits& units) const;
  /// Forgets all light and all camera samples.
  void reset(uint32_t seed);
  /// Follows the camera and the image's size; what texel sides know stays. False where all must be built again.
  bool set_frame(const TechniqueContext& c, const Parameters& p, uint32_t seed);
  bool gathers() const { return camera->pixel_gather() != nullptr; }  ///< pixels, along bundles
  /// Pixels gather what texel sides send along direction `index`, which itself changes nothing that texel sides know.
  /// `first` as for BundleTransfer::gather(). False when cancelled; may be done again.
  bool gather_along(const DirectionSequence& sequence, uint64_t index, uint32_t seed, bool first);
  /// Gives away what holds surfaces and their emission only; these parts are of no use then.
  Kept release_surfaces();
  /// What is held at a point, for Technique::inspect().
  InspectedValues inspect(const SeenPoint& point) const;
  /// After `directions` directions.
  std::map<std::string, double> counters(uint64_t directions) const;
  void write(Film& film, bool smoothed) const;
  void warm_up();

  std::unique_ptr<SurfaceAtlas> atlas;
  Program program;
  std::unique_ptr<TexelInterior> interior;
  std::unique_ptr<SideAccessibility> accessibility;
  SideLight side_light;
  SideMeans means;
  std::unique_ptr<SidePreview> preview;      ///< null unless asked for
  std::unique_ptr<SideSpecular> specular;    ///< null where no texel side has a specular lobe that takes part
  std::unique_ptr<CameraLight> camera;       ///< never null
  std::unique_ptr<BundleTransfer> transfer;  ///< likewise
  std::unique_ptr<SideState> side_state;     ///< null unless asked for, and where bundles carry nothing
  std::unique_ptr<DebugLayers> debug;        ///< null unless asked for

 private:
  void make_camera(const TechniqueContext& c);
  void make_transfer(const TechniqueContext& c, const Parameters& p);
  void make_debug(const TechniqueContext& c);
  BundlePlan plan_;
  bool measures_;                 ///< how far samples of pixels scatter
  uint64_t seen_directions_ = 0;  ///< of texels, at the last sample of pixels
};

}  // namespace lucarium::bundle
