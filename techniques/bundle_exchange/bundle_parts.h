// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "bundle_exchange/bundle_plan.h"
#include "bundle_exchange/exchange/bundle_transfer.h"
#include "bundle_exchange/specular/slot_specular.h"
#include "bundle_exchange/texels/slot_light.h"

namespace lucarium::bundle {

/// Everything that is made for one scene, in the order of dependence.
struct BundleParts {
  /// What may outlast a change of the scene, or null: the atlas, and what of its texels counts.
  struct Kept {
    std::unique_ptr<SurfaceAtlas> atlas;
    std::unique_ptr<TexelInterior> exposure;
    std::unique_ptr<SlotOpenness> openness;
  };

  BundleParts(const TechniqueContext& c, const Parameters& p, const BundlePlan& plan, Kept kept);
  /// What of texels is hidden, and how open the rest is. `report`: as TechniqueContext::progress. Throws
  /// Error{interrupted} when cancelled.
  void measure_openness(const std::function<void(double, const std::string&)>& report);
  void warm_up();

  std::unique_ptr<SurfaceAtlas> atlas;
  Program program;
  std::unique_ptr<TexelInterior> exposure;
  std::unique_ptr<SlotOpenness> openness;
  SlotLight slot_light;
  SlotMeans means;
  std::unique_ptr<SlotPreview> preview;    ///< null unless asked for
  std::unique_ptr<SlotSpecular> specular;  ///< null where no slot has a specular lobe that takes part
  CameraLight camera;
  BundleTransfer transfer;
};

}  // namespace lucarium::bundle
