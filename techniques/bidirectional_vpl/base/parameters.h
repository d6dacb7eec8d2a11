// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium::bidirectional {

enum class VplChoice { resample, all, own, pair };
enum class LightChoice { power, learned };
enum class LightTrace { bvh, rsm };
enum class VplLights { all, punctual };
enum class VplVisibility { rays, map };
enum class Direct { mis, maps };
enum class Directions { bsdf, bundle, both };
enum class DirectionPdf { uniform, environment };
enum class BundleSides { two, one };
enum class Reuse { per_depth, distinct, shared };
enum class BundleMode { rays, raster, linked_list, exact };
enum class TwoBounce { mis, compensate, clamp };
enum class Gloss { none, clamp, vsl, roughness };
enum class Strategy { all, hit, nee, vpl, splat };

struct BidirectionalParameters {
  static constexpr int kMaxLightVertices = 16, kMaxCameraEdges = 64;
  int light_vertices = 4, light_paths = 0, candidates = 32, camera_edges = 4, beta = 1;
  int bundles = 21, bundle_res = 256;
  BundleMode bundle_mode = BundleMode::rays;
  Directions directions = Directions::bsdf;
  DirectionPdf dir_pdf = DirectionPdf::uniform;
  BundleSides bundle_sides = BundleSides::two;
  Reuse reuse = Reuse::per_depth;
  VplChoice vpl_choice = VplChoice::resample;
  LightChoice light_choice = LightChoice::power;
  LightTrace light_trace = LightTrace::bvh;
  VplLights vpl_lights = VplLights::all;
  VplVisibility vpl_visibility = VplVisibility::rays;
  int map_res = 256;
  Direct direct = Direct::mis;
  TwoBounce two_bounce = TwoBounce::mis;
  float g_max = 1, m_prime = 16;
  Gloss gloss = Gloss::none;
  bool splat = true, guide = true, show_strategies = false;
  int interleave = 1;
  bool caches = false, filter = false, adapt = true;
  Strategy strategy = Strategy::all;

  template <class V>
  void describe(V& v) {
    v.number("light_vertices", light_vertices, 1, kMaxLightVertices, "vertices", "maximum vertices of a light path");
    v.number("light_paths", light_paths, 0, 1 << 22, "paths",
             "light paths per iteration; 0: one for 8 pixels, with vpl_choice=own one per pixel, with all and pair as "
             "many as bundles");
    v.choice("light_choice", light_choice, {{"power", LightChoice::power}, {"learned", LightChoice::learned}},
             "lights that light paths start from: by their power, or half of the paths by what each light has brought "
             "to the image so far (learned)");
    v.choice("light_trace", light_trace, {{"bvh", LightTrace::bvh}, {"rsm", LightTrace::rsm}},
             "what finds first surfaces of light paths: rays (bvh), or reflective shadow maps of point and spot lights "
             "(rsm, biased by their texels)");
    v.choice("vpl_lights", vpl_lights, {{"all", VplLights::all}, {"punctual", VplLights::punctual}},
             "lights that light paths start from: all, or point, spot and directional lights (punctual)");
    v.choice(
        "vpl_choice", vpl_choice,
        {{"resample", VplChoice::resample},
         {"all", VplChoice::all},
         {"own", VplChoice::own},
         {"pair", VplChoice::pair}},
        "virtual lights that a camera path's vertex is connected to: one of many candidates (resample), all, or one "
        "of the light path of its pixel (own) or bundle (pair)");
    v.number("candidates", candidates, 1, 256, "virtual lights", "candidates per connection (vpl_choice=resample)");
    v.choice("vpl_visibility", vpl_visibility, {{"rays", VplVisibility::rays}, {"map", VplVisibility::map}},
             "what finds whether a virtual light is hidden: rays, or a shadow map of each (map, biased by texels)");
    v.number("map_res", map_res, 32, 1024, "texels", "square root of the texels of a virtual light's shadow map");
    v.choice(
        "direct", direct, {{"mis", Direct::mis}, {"maps", Direct::maps}},
        "what finds whether a light sample is hidden: rays (mis), or filtered shadow maps of point and spot lights "
        "(maps, biased by texels)");
    v.flag("splat", splat, "connect light paths to the camera; only with jittered pixels");
    v.flag("guide", guide,
           "behind mirrors and glass let camera paths go where light paths have come from through others, to find "
           "what these show of caustics");
    v.number("camera_edges", camera_edges, 1, kMaxCameraEdges, "scatterings",
             "scatterings of a camera path before roulette by what it carries");
    v.choice("directions", directions,
             {{"bsdf", Directions::bsdf}, {"bundle", Directions::bundle}, {"both", Directions::both}},
             "directions of camera paths: by BSDF samples, from a set that all pixels share (bundle), or in turn at "
             "the first surface and by BSDF samples from there on (both)");
    v.number("bundles", bundles, 1, 4096, "directions",
             "number of shared directions per iteration (directions=bundle, both), and of light paths (vpl_choice=all, "
             "pair)");
    v.choice("dir_pdf", dir_pdf, {{"uniform", DirectionPdf::uniform}, {"env", DirectionPdf::environment}},
             "density of shared directions: uniform, or mostly by the luminance of the environment (env)");
    v.choice("bundle_sides", bundle_sides, {{"two", BundleSides::two}, {"one", BundleSides::one}},
             "surfaces that a shared direction serves: all, each on its own side (two), or those that it leaves in "
             "front (one, as a shadow map of the direction would)");
    v.choice(
        "reuse", reuse, {{"per_depth", Reuse::per_depth}, {"distinct", Reuse::distinct}, {"shared", Reuse::shared}},
        "shared directions at later scatterings: from a set per depth, distinct independent ones, or the first set "
        "again (shared, biased)");
    v.choice(
        "bundle_mode", bundle_mode,
        {{"rays", BundleMode::rays},
         {"raster", BundleMode::raster},
         {"linked_list", BundleMode::linked_list},
         {"exact", BundleMode::exact}},
        "what finds surfaces along shared directions: rays, fragments of a rasterized bundle (stored in tiles, or in "
        "linked lists), or all triangles that a pixel touches (exact)");
    v.number("bundle_res", bundle_res, 32, 4096, "pixels", "width and height of a rasterized bundle");
    v.choice("two_bounce", two_bounce,
             {{"mis", TwoBounce::mis}, {"compensate", TwoBounce::compensate}, {"clamp", TwoBounce::clamp}},
             "two and more bounces: weighted (mis), or by connections of clamped geometric factor, the rest left to "
             "camera paths (compensate) or out (clamp, biased)");
    v.number("g_max", g_max, 1e-6f, 1e12f, "1/m²", "largest geometric factor of a connection that is clamped");
    v.choice("gloss", gloss,
             {{"none", Gloss::none}, {"clamp", Gloss::clamp}, {"vsl", Gloss::vsl}, {"roughness", Gloss::roughness}},
             "spikes of glossy surfaces by few samples: kept (none), cut (clamp), spread over spheres about virtual "
             "lights (vsl) or by wider lobes (roughness); the bias dies out with samples");
    v.number("m_prime", m_prime, 1.f, 64.f, "samples",
             "minimum number of samples that a glossy lobe covers (gloss=clamp, roughness)");
    v.number("interleave", interleave, 1, 8, "pixels",
             "side of the tiles whose pixels take different bundles and virtual lights of an iteration");
    v.flag("filter", filter,
           "average over a tile (interleave) until each pixel has as many samples as the tile has pixels");
    v.flag("caches", caches,
           "animations: compute indirect light for one sample in four, and reproject the others from the frame before");
    v.flag("adapt", adapt,
           "from sample 16 on, leave out splats, light paths or their later vertices where they cost more than they "
           "bring, and choose camera_edges (vpl_choice=resample, light_paths=0)");
    v.number("beta", beta, 1, 2, "", "exponent of the weights: 1 balance heuristic, 2 power heuristic");
    v.choice("strategy", strategy,
             {{"all", Strategy::all},
              {"hit", Strategy::hit},
              {"nee", Strategy::nee},
              {"vpl", Strategy::vpl},
              {"splat", Strategy::splat}},
             "strategies that are run: all, or one alone, which finds only a part of the paths");
    v.flag("show_strategies", show_strategies, "write a layer of each strategy's light");
    v.presets(
        {{"bdpt", {{"vpl_choice", "own"}, {"light_vertices", "16"}, {"guide", "off"}, {"adapt", "off"}}},
         {"paper",
          {{"light_vertices", "1"},
           {"light_trace", "rsm"},
           {"vpl_lights", "punctual"},
           {"vpl_choice", "pair"},
           {"splat", "off"},
           {"directions", "bundle"},
           {"camera_edges", "1"},
           {"bundle_mode", "linked_list"},
           {"vpl_visibility", "map"},
           {"direct", "maps"},
           {"two_bounce", "clamp"},
           {"gloss", "roughness"},
           {"interleave", "4"},
           {"caches", "on"},
           {"filter", "on"},
           {"adapt", "off"}}},
         {"preview", {{"interleave", "4"}, {"filter", "on"}, {"caches", "on"}, {"adapt", "off"}}}},
        "set of values: of bidirectional path tracing with a light path per pixel (bdpt), of the paper (paper), or "
        "for few samples, filtered (preview)");
    v.basic({"preset", "light_vertices", "light_paths", "candidates", "splat", "strategy", "show_strategies"});
  }
};

}  // namespace lucarium::bidirectional
