// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bidirectional_vpl/base/parameters.h"
#include "bidirectional_vpl/shared/settings.h"
#include "lucarium/technique/technique.h"

namespace lucarium::bidirectional {

/// What an iteration is made of, from parameters and image.
struct Plan {
  BidirectionalSettings settings{};
  uint32_t light_vertices = 0;  ///< of a light path; 0: no light paths
  uint32_t beta = 1;
  bool bundles = false, bundles_follow_sky = false, bundles_one_sided = false;  ///< directions of camera paths
  bool bundles_and_bsdf = false;                                                ///< both, at first surfaces
  BundleMode bundle_mode = BundleMode::rays;                                    ///< rays where there are no bundles
  uint32_t bundle_res = 0;  ///< pixels per axis of a rasterized bundle
  VplChoice choice = VplChoice::resample;
  TwoBounce two_bounce = TwoBounce::mis;
  Gloss gloss = Gloss::none;
  bool filter = false, caches = false;
  bool learned = false;         ///< lights of light paths
  bool punctual_paths = false;  ///< light paths start from point, spot and directional lights
  bool rsm = false, vpl_maps = false, direct_maps = false;  ///< maps/
  uint32_t map_res = 0;                                     ///< root of the texels of a VPL's map
  bool vpl = false;                                         ///< camera paths are connected to light vertices
  bool splat = false;                                       ///< light vertices are connected to the camera
  bool guide = false;                                       ///< light paths guide camera paths (guide/)
  bool lights = false;                                      ///< light samples are taken
  bool shows_strategies = false;

  /// Whether connections compare candidates from a table.
  bool has_table() const { return vpl && choice == VplChoice::resample; }
  bool connects_to_all() const { return vpl && choice == VplChoice::all; }
  /// Whether bundles are rasterized and looked up.
  bool stores_bundles() const { return bundle_mode != BundleMode::rays; }
  /// Whether a camera path may take more than one bundle, so that it matters which.
  bool takes_several_bundles() const { return bundles && !bundles_and_bsdf && settings.max_scatterings > 1; }
  /// Whether later depths look up the bundles of the first one, where there is memory.
  bool keeps_bundles() const {
    return stores_bundles() && takes_several_bundles() && settings.reuse == BIDIRECTIONAL_REUSE_SHARED;
  }
  size_t vertex_slots() const { return size_t{settings.light_paths} * light_vertices; }
  /// Layers of a sample, strategies behind them: hit, nee, vpl1 …, splat.
  uint32_t layers() const { return BIDIRECTIONAL_LAYERS + (shows_strategies ? light_vertices + 3 : 0); }
  /// Of the layers of strategies, in their order.
  std::vector<std::string> strategy_names() const;
};

/// What adapt=on decides about: what an iteration does of what the parameters allow.
struct Effort {
  bool light_paths = true, splats = true;
  int light_vertices = 1, camera_edges = 1;
  bool operator==(const Effort&) const = default;
};

/// All that the parameters allow.
Effort whole_effort(const BidirectionalParameters& parameters);

Plan make_plan(const BidirectionalParameters& parameters, const RenderSettings& settings);
Plan make_plan(const BidirectionalParameters& parameters, const RenderSettings& settings, const Effort& effort);

/// What all programs of the technique are compiled with.
std::map<std::string, std::string> plan_defines(const Plan& plan);
/// And those of camera paths.
std::map<std::string, std::string> eye_defines(const Plan& plan);

}  // namespace lucarium::bidirectional
