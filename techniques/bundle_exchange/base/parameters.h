// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/bundles/direction_sequence.h"
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
  float open_gap = 2;
  int open_rays = 256;
  DirectMode direct_mode = DirectMode::nee;
  int direct_first = 8;
  float gain_exp = 0.5f;
  float avg_exp = 0.5f;
  bool balance = true;
  GlossyBounces glossy_bounces = GlossyBounces::multiple;
  FinalGather final_gather = FinalGather::glossy;
  int glossy_window = 0;
  GlossyNorm glossy_norm = GlossyNorm::self;
  float alpha_ring = 0;
  float hop_share = 0.5f;
  Transfer transfer = Transfer::ray;
  PixelRays pixel_rays = PixelRays::traced;
  bool preview = false;
  bool warm_start = false;
  float stop_error = 0.01f;
  int camera_samples = 64;

  template <class V>
  void describe(V& v) {
    v.number("directions", directions, 1, 1000000, "directions", "directions of exchange");
    v.number("batch", batch, 1, 64, "directions", "directions that share one set of senders; begins at 1 and grows");
    v.choice("sequence", sequence,
             {{"iid", DirectionOrder::iid},
              {"blocks", DirectionOrder::blocks},
              {"halton", DirectionOrder::halton},
              {"hammersley", DirectionOrder::hammersley}},
             "directions: independent, Owen-scrambled Sobol points in blocks, Halton, or Hammersley points");
    v.choice(
        "interleave", interleave,
        {{"sd", Interleave::sd},
         {"running", Interleave::running},
         {"fixed", Interleave::fixed},
         {"pingpong", Interleave::pingpong}},
        "how bounces share directions: forgetting senders beside a slow mean (sd), a running mean, equal shares of "
        "the total (fixed, loses energy), or one bounce after the other, each `block` directions (pingpong)");
    v.number("block", block, 128, 16384, "directions", "directions of a stratified block, and of a bounce of pingpong");
    v.number("env_guiding", env_guiding, 0.f, 0.9f, "", "share of directions drawn by the environment's luminance");
    v.number("texels", texels, 0, 1 << 24, "texels",
             "wanted size of the surface atlas; 0: eight per pixel of the image, but 32768 to 262144");
    v.number("pixel_size", pixel_size, 0.1f, 2.f, "texel edges", "edge of a film pixel of a bundle");
    v.number("open_gap", open_gap, 0.f, 16.f, "texel edges",
             "rays that go farther tell how open a part of a texel is, and what it counts in the texel's mean; 0: all "
             "alike");
    v.number("open_rays", open_rays, 128, 4096, "rays",
             "of a texel, if it faced all directions, by which that is measured; of at least 32 bundles");
    v.choice("direct_mode", direct_mode, {{"nee", DirectMode::nee}, {"exchange", DirectMode::exchange}},
             "light of emissive surfaces and the environment: by light samples, or by the bundles themselves");
    v.number("direct_first", direct_first, 0, 100000, "directions",
             "directions that carry emitted light only, before the others (direct_mode=exchange)");
    v.number("gain_exp", gain_exp, 0.3f, 1.f, "",
             "step of senders: batch k counts k^-gain_exp of the mean (interleave=sd)");
    v.number("avg_exp", avg_exp, 0.f, 2.f, "", "weight of direction i in what is displayed: i^avg_exp (interleave=sd)");
    v.flag("balance", balance,
           "scale senders so that they send the power that receivers hold (unlimited bounces; not while specular lobes "
           "deliver "
           "more than a fifth)");
    v.choice("final_gather", final_gather,
             {{"off", FinalGather::off}, {"glossy", FinalGather::glossy}, {"all", FinalGather::all}},
             "reflections towards the eye that are gathered by rays: none, specular lobes, or the diffuse lobe too");
    v.choice("glossy_bounces", glossy_bounces, {{"multiple", GlossyBounces::multiple}, {"final", GlossyBounces::final}},
             "specular lobes take part in the exchange, or only reflect diffuse light towards the eye");
    v.number(
        "glossy_window", glossy_window, 0, 256, "directions",
        "directions before the next one that glossy slots reflect towards it, instead of tracing rays; 0: all rays, 1: "
        "as in the paper");
    v.choice("glossy_norm", glossy_norm, {{"self", GlossyNorm::self}, {"mean", GlossyNorm::mean}},
             "light of those directions is divided by their weights (self, less noise), or by their number (mean)");
    v.number("alpha_ring", alpha_ring, 0.f, 1.f, "",
             "smallest GGX width of slots that reflect directions instead of tracing rays; 0: sqrt(2 / glossy_window)");
    v.number("hop_share", hop_share, 0.01f, 1.f, "",
             "probability that a slot which reflects everything specularly traces a ray for a direction; others less");
    v.choice("transfer", transfer, {{"ray", Transfer::ray}, {"texel", Transfer::texel}},
             "who meets whom: all film pixels' fragments each other, or each texel, projected into the film, its "
             "neighbour there "
             "(texel, as in the paper)");
    v.choice("pixel_rays", pixel_rays, {{"traced", PixelRays::traced}, {"bundle", PixelRays::bundle}},
             "rays of final_gather: traced, or those of the bundles (bundle, as in the paper; lobes below alpha_ring "
             "are traced)");
    v.flag("preview", preview,
           "until the exchange is done, show the atlas smoothed as far as its errors go (interleave=sd and running)");
    v.flag("warm_start", warm_start,
           "after changes of lights, materials and geometry senders go on from what they knew (interleave=sd and "
           "running)");
    v.number("stop_error", stop_error, 0.f, 1.f, "",
             "converged at this relative standard error of irradiance (interleave=sd and running); 0: never. With "
             "direct_mode=exchange "
             "directions carry emission only as soon as at most half of the squared error comes from indirect light");
    v.number(
        "camera_samples", camera_samples, 1, 1 << 24, "samples",
        "samples per pixel that an image has at least when it counts as converged: direct light and edges are theirs");
    v.presets({{"paper",
                {{"batch", "1"},
                 {"sequence", "halton"},
                 {"interleave", "running"},
                 {"direct_mode", "exchange"},
                 {"avg_exp", "0"},
                 {"open_gap", "0"},
                 {"balance", "off"},
                 {"glossy_window", "1"},
                 {"glossy_norm", "mean"},
                 {"alpha_ring", "0.001"},
                 {"transfer", "texel"},
                 {"pixel_rays", "bundle"},
                 {"stop_error", "0"}}}},
              "paper: the variants of Hermes et al. 2010");
  }
};

/// Whether senders forget: what they knew before does no harm, and the error of a mean is that of the image.
inline bool forgets(const Parameters& parameters) {
  return parameters.interleave == Interleave::sd || parameters.interleave == Interleave::running;
}

/// The directions of the exchange. `permuted`: where slots reflect directions, for pairs of them.
inline DirectionSequence make_sequence(const Parameters& parameters, uint64_t seed,
                                       std::shared_ptr<const EnvironmentGuide> guide = nullptr, bool permuted = false) {
  DirectionOptions options;
  options.order = parameters.sequence;
  options.block = static_cast<uint32_t>(parameters.block);
  options.total = static_cast<uint32_t>(parameters.directions);
  options.guiding = static_cast<double>(parameters.env_guiding);
  options.permuted = permuted;
  return DirectionSequence(options, seed, std::move(guide));
}

}  // namespace lucarium::bundle
