// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "lucarium/services/bundles/direction_sequence.h"
#include "lucarium/services/surface_atlas/most_texels.h"
#include "lucarium/technique/parameters.h"

namespace lucarium::bundle {

enum class Interleave { sd, running, fixed, pingpong };
enum class DirectMode { nee, exchange };
enum class FinalGather { off, glossy, all };
enum class GlossyBounces { multiple, final };
enum class Transfer { ray, texel };
enum class PixelRays { traced, bundle };
enum class GlossyNorm { self, mean };

/// Every parameter of the technique, once: default, range, unit and meaning.
struct Parameters {
  int directions = 2000;
  int batch = 4;
  DirectionOrder sequence = DirectionOrder::blocks;
  Interleave interleave = Interleave::sd;
  int block = 2048;
  float env_guiding = 0;
  int texels = 0;
  float pixel_size = 0.5f;
  float access_gap = -1;
  int access_rays = 256;
  DirectMode direct_mode = DirectMode::nee;
  int direct_first = 8;
  float step_exponent = 0.5f;
  float average_exponent = 0.5f;
  bool balance = true;
  GlossyBounces glossy_bounces = GlossyBounces::multiple;
  FinalGather final_gather = FinalGather::glossy;
  int glossy_window = 0;
  GlossyNorm glossy_norm = GlossyNorm::self;
  float history_alpha = 0;
  float chain_share = 0.5f;
  Transfer transfer = Transfer::ray;
  PixelRays pixel_rays = PixelRays::traced;
  bool preview = false;
  bool warm_start = false;
  bool debug_layers = false;
  float stop_error = 0.01f;
  int camera_samples = 64;
  float eye_share = -1;

  template <class V>
  void describe(V& v) {
    v.number("directions", directions, 0, 1000000, "directions",
             "number of directions along which light is exchanged; 0: no limit");
    v.number("batch", batch, 1, 64, "directions",
             "maximum directions per batch; directions of a batch share their senders");
    v.choice(
        "sequence", sequence,
        {{"iid", DirectionOrder::iid},
         {"blocks", DirectionOrder::blocks},
         {"halton", DirectionOrder::halton},
         {"hammersley", DirectionOrder::hammersley}},
        "directions: independent (iid), Owen-scrambled Sobol points in blocks, Halton points, or Hammersley points");
    v.choice("interleave", interleave,
             {{"sd", Interleave::sd},
              {"running", Interleave::running},
              {"fixed", Interleave::fixed},
              {"pingpong", Interleave::pingpong}},
             "how bounces share directions: a fast mean to send and a slow one to show (sd), a running mean, equal "
             "shares (fixed, loses energy), or bounce after bounce (pingpong)");
    v.number("block", block, 128, 16384, "directions",
             "directions per stratified block; with interleave=pingpong also per bounce");
    v.number("env_guiding", env_guiding, 0.f, 0.9f, "",
             "share of directions that are sampled by the luminance of the environment");
    v.number("texels", texels, 0, kMaxAtlasTexels, "texels",
             "target size of the surface atlas; 0: eight per pixel, or one for four triangles if that is more; "
             "at least 32768 and at most 262144");
    v.number("pixel_size", pixel_size, 0.1f, 2.f, "texel edges", "edge length of a pixel of the bundle image");
    v.number("access_gap", access_gap, -1.f, 16.f, "texel edges",
             "longer rays are free, which weights texel parts, and parts closer under glass are kept apart; "
             "0: neither; -1: 8, up to a tenth of the scene, under glass 2");
    v.number("access_rays", access_rays, 128, 4096, "rays",
             "rays per texel that measure its accessibility, from at least 32 bundles");
    v.choice("direct_mode", direct_mode, {{"nee", DirectMode::nee}, {"exchange", DirectMode::exchange}},
             "direct light of emissive surfaces and the environment: light samples (nee) or the bundles (exchange)");
    v.number("direct_first", direct_first, 0, 100000, "directions",
             "first directions, which carry emission only (direct_mode=exchange)");
    v.number("step_exponent", step_exponent, 0.3f, 1.f, "",
             "step of the mean that is sent: batch k has weight k^-step_exponent (interleave=sd)");
    v.number("average_exponent", average_exponent, 0.f, 2.f, "",
             "weight of the mean that is displayed: direction i has weight i^average_exponent (interleave=sd)");
    v.flag("balance", balance,
           "scale senders so that they send the power that receivers hold (unlimited bounces; off while specular lobes "
           "deliver more than a fifth)");
    v.choice("final_gather", final_gather,
             {{"off", FinalGather::off}, {"glossy", FinalGather::glossy}, {"all", FinalGather::all}},
             "lobes whose light pixels gather by rays: none, specular (glossy), or specular and diffuse (all)");
    v.choice("glossy_bounces", glossy_bounces, {{"multiple", GlossyBounces::multiple}, {"final", GlossyBounces::final}},
             "specular lobes reflect at every bounce (multiple), or at the last one, towards the eye (final)");
    v.number("glossy_window", glossy_window, 0, 256, "directions",
             "number of past directions that glossy texel sides reflect; 0: trace rays instead, 1 with "
             "glossy_norm=mean: the paper's transfer atlas");
    v.choice("glossy_norm", glossy_norm, {{"self", GlossyNorm::self}, {"mean", GlossyNorm::mean}},
             "normalization of the light of past directions: by BSDF weights (self, less noise, small bias) or by "
             "their number (mean, unbiased)");
    v.number("history_alpha", history_alpha, 0.f, 1.f, "",
             "minimum GGX alpha of texel sides that reflect past directions, smoother ones trace rays; 0: sqrt(2 / "
             "glossy_window)");
    v.number(
        "chain_share", chain_share, 0.01f, 1.f, "",
        "probability that a perfect mirror traces a specular chain, per direction; scaled by specular reflectance");
    v.choice("transfer", transfer, {{"ray", Transfer::ray}, {"texel", Transfer::texel}},
             "ray: exchange between consecutive fragments of a pixel; texel: project each texel and read its neighbour "
             "(paper)");
    v.choice("pixel_rays", pixel_rays, {{"traced", PixelRays::traced}, {"bundle", PixelRays::bundle}},
             "rays of final_gather: traced, or those of the bundles (paper; lobes below history_alpha are traced)");
    v.flag("preview", preview, "show a smoothed atlas until the exchange is done (interleave=sd or running)");
    v.flag("warm_start", warm_start,
           "keep the mean that is sent when lights, materials or geometry change (interleave=sd or running)");
    v.flag(
        "debug_layers", debug_layers,
        "also write the parts of direct and indirect light, and accessibility, balance and direction history of texel "
        "sides");
    v.number("stop_error", stop_error, 0.f, 1.f, "",
             "relative standard error of irradiance at which the image counts as converged; 0: never (interleave=sd or "
             "running)");
    v.number("camera_samples", camera_samples, 0, 1 << 24, "samples",
             "minimum samples per pixel before the image counts as converged; 0: it never does");
    v.number(
        "eye_share", eye_share, -1.f, 0.9f, "",
        "share of the work that goes to samples of pixels, half where one costs more than an iteration; 0: one per "
        "iteration (pixel_rays=bundle: always), -1: by measured variances");
    v.presets({{"paper",
                {{"batch", "1"},
                 {"eye_share", "0"},
                 {"sequence", "halton"},
                 {"interleave", "running"},
                 {"direct_mode", "exchange"},
                 {"average_exponent", "0"},
                 {"access_gap", "0"},
                 {"balance", "off"},
                 {"glossy_window", "1"},
                 {"glossy_norm", "mean"},
                 {"history_alpha", "0.001"},
                 {"transfer", "texel"},
                 {"pixel_rays", "bundle"},
                 {"stop_error", "0"}}}},
              "set of values; paper: the choices of Hermes et al. 2010");
    v.basic({"directions", "texels", "direct_mode", "final_gather", "stop_error", "camera_samples", "chain_share",
             "glossy_window", "preview", "warm_start"});
  }
};

/// Whether senders forget: what they knew before does no harm, and the error of a mean is that of the image.
inline bool forgets(const Parameters& parameters) {
  return parameters.interleave == Interleave::sd || parameters.interleave == Interleave::running;
}

/// Directions after which the exchange ends.
inline uint64_t direction_limit(const Parameters& parameters) {
  return parameters.directions > 0 ? static_cast<uint64_t>(parameters.directions) : UINT64_MAX;
}

/// The directions of the exchange. `permuted`: where texel sides reflect directions, for pairs of them; near ones must
/// come together in a block, which holds 64 windows at least.
inline DirectionSequence make_sequence(const Parameters& parameters, uint64_t seed,
                                       std::shared_ptr<const EnvironmentGuide> guide = nullptr, bool permuted = false) {
  DirectionOptions options;
  options.order = parameters.sequence;
  options.block =
      static_cast<uint32_t>(permuted ? std::max(parameters.block, 64 * parameters.glossy_window) : parameters.block);
  options.total = static_cast<uint32_t>(parameters.directions);
  options.guiding = static_cast<double>(parameters.env_guiding);
  options.permuted = permuted;
  return DirectionSequence(options, seed, std::move(guide));
}

}  // namespace lucarium::bundle
