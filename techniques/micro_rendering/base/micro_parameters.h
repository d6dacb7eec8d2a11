// SPDX-License-Identifier: Apache-2.0
// Parameters of the technique.
#pragma once
#include <algorithm>

#include "lucarium/technique/parameters.h"

namespace lucarium::micro {

enum class CutBound { conservative, centre };
enum class Splat { sample, nearest };
enum class Warp { analytic, table, nusselt };
enum class Backface { black, cull };
enum class NodeShading { stored, dynamic };
enum class DepthBits { eight, thirty_two };
enum class MultiBounce { jacobi, instant_radiosity, photon_map };

struct MicroParameters {
  int points_log2 = 18;
  int micro_size = 24;
  float cut_kappa = 1;
  CutBound cut_bound = CutBound::conservative;
  float cut_error = 0;
  Splat splat = Splat::sample;
  float splat_radius = 1.35f;
  float disc_scale = 1.6f;
  Warp warp = Warp::analytic;
  int table_size = 32;
  bool hole_fill = true;
  bool raycast = true;
  bool morton = true;
  Backface backface = Backface::black;
  bool skip_hidden = true;
  float adaptive = 0;
  int gather_step = 1;
  float upsample_fail = 0.05f;
  bool gather_env = false;
  NodeShading node_shading = NodeShading::stored;
  MultiBounce multibounce = MultiBounce::jacobi;
  int jacobi_level = 12;
  float jacobi_cone = 30;
  DepthBits depth_bits = DepthBits::thirty_two;
  int vpls = 256;
  float vpl_clamp = 100;
  bool final_gather = true;
  int photons = 1000000;
  int photon_k = 50;
  bool photon_direct = false;
  int light_samples = 1;
  int direct_samples = 4;
  int unlimited_bounces = 4;
  int batch_gathers = 4096;
  int inspect_x = -1, inspect_y = -1;

  /// Longest edge of a micro-buffer.
  int largest_edge() const { return adaptive > 0 ? std::min(64, micro_size * 3 / 2) : micro_size; }
  /// Whether gathers at pixels know what the frames before have found.
  bool keeps_levels() const { return cut_error > 0 || adaptive > 0; }

  /// Whether virtual lights light the visible points themselves.
  bool shows_virtual_lights() const { return !final_gather && multibounce == MultiBounce::instant_radiosity; }

  template <class V>
  void describe(V& v) {
    v.number("points_log2", points_log2, 10, 23, "log2", "points on the scene's surfaces: leaves of the hierarchy");
    v.number("micro_size", micro_size, 8, 64, "micro-pixels", "edge of a micro-buffer");
    v.number("cut_kappa", cut_kappa, 0.25f, 4, "micro-pixels", "solid angle above which a node is split");
    v.choice("cut_bound", cut_bound, {{"conservative", CutBound::conservative}, {"centre", CutBound::centre}},
             "size of a micro-pixel that a node is compared with: the smallest over the node, or that at its centre");
    v.number("cut_error", cut_error, 0, 1, "",
             "share of a micro-buffer's mean that a node may err by: uneven ones are split, to cut_kappa / 4; where "
             "all are even the cut is 4 times as coarse; 0: off");
    v.choice("splat", splat, {{"sample", Splat::sample}, {"nearest", Splat::nearest}},
             "which micro-pixels a node covers: those whose sample direction meets its disc, or the one at its centre");
    v.number("splat_radius", splat_radius, 0.8f, 1.7f, "",
             "radius of a splat over that of the disc of the node's area");
    v.number("disc_scale", disc_scale, 1, 2.2f, "",
             "radius of a leaf's disc over that of the disc of its area, which is the inverse of the points' density");
    v.choice("warp", warp, {{"analytic", Warp::analytic}, {"table", Warp::table}, {"nusselt", Warp::nusselt}},
             "projection of micro-buffers: by the lobes' own maps, by tables of the BSDF, or none (the unit disc)");
    v.number("table_size", table_size, 8, 64, "cells", "edge of the tables of warp=table");
    v.flag("hole_fill", hole_fill, "empty micro-pixels among covered ones take the mean of their neighbours");
    v.flag("raycast", raycast, "leaves larger than a micro-pixel are ray-cast as discs");
    v.flag("morton", morton, "gather in Morton order of the points, not of the pixels");
    v.choice("backface", backface, {{"black", Backface::black}, {"cull", Backface::cull}},
             "what single-sided surfaces are from behind: black, as for the reference, or transparent");
    v.flag(
        "skip_hidden", skip_hidden,
        "no points inside solids of single-sided surfaces, whose backs are transparent where nothing else sees them");
    v.number("adaptive", adaptive, 0, 1, "",
             "relative deviation between frames above which, and where interpolation fails, micro-buffers get edges "
             "1.5 times as long, 64 at most; 0: off");
    v.number("gather_step", gather_step, 1, 8, "pixels",
             "gather at every n-th pixel of every n-th row, and interpolate; above 1 all gathers of a frame are one "
             "iteration");
    v.number("upsample_fail", upsample_fail, 0, 1, "",
             "weight of neighbours below which a pixel gathers itself; 0: never, what nothing agrees with takes what "
             "there is");
    v.flag("gather_env", gather_env,
           "empty micro-pixels see the environment; light samples of the layer direct leave it out");
    v.choice(
        "node_shading", node_shading, {{"stored", NodeShading::stored}, {"dynamic", NodeShading::dynamic}},
        "what nodes shine with: their diffuse lobes, stored before, or their glossy ones too, towards each gather");
    v.choice("multibounce", multibounce,
             {{"jacobi", MultiBounce::jacobi},
              {"instant_radiosity", MultiBounce::instant_radiosity},
              {"photon_map", MultiBounce::photon_map}},
             "how light reaches the points over several bounces");
    v.number("jacobi_level", jacobi_level, 6, 23, "log2", "nodes of this level gather for the bounces before the last");
    v.number("jacobi_cone", jacobi_cone, 1, 180, "degrees",
             "spread of normals beyond which nodes below them gather instead; at most twice as many in all");
    v.number("vpls", vpls, 1, 65536, "paths",
             "light paths of instant radiosity; each has one virtual light per bounce");
    v.number("vpl_clamp", vpl_clamp, 0.01f, 1e6f, "1/R²",
             "bound of a virtual light's geometry term, R the scene's radius");
    v.flag("final_gather", final_gather,
           "gather; off, with multibounce=instant_radiosity: virtual lights light the diffuse lobes of visible points "
           "themselves, for comparison");
    v.number("photons", photons, 1000, 1 << 24, "paths", "light paths of the photon map");
    v.number("photon_k", photon_k, 4, 256, "photons", "from which a density is estimated");
    v.flag("photon_direct", photon_direct, "photons stand for direct light too, instead of light samples");
    v.choice("depth_bits", depth_bits, {{"8", DepthBits::eight}, {"32", DepthBits::thirty_two}},
             "bits of the micro-buffers' depth");
    v.number("light_samples", light_samples, 1, 1024, "samples/point", "light samples per point and frame");
    v.number("direct_samples", direct_samples, 1, 1024, "samples/pixel", "samples of the layer direct per frame");
    v.number("unlimited_bounces", unlimited_bounces, 1, 32, "bounces",
             "bounces that are computed where their number is not limited");
    v.number(
        "batch_gathers", batch_gathers, 64, 1 << 24, "gathers",
        "most gathers of one iteration at pixels; light at points takes iterations of its own beyond as much work");
    v.number("inspect_x", inspect_x, -1, 1 << 15, "pixels",
             "column of the pixel whose micro-buffer is shown; -1: none");
    v.number("inspect_y", inspect_y, -1, 1 << 15, "pixels", "row of that pixel");
    v.presets({{"paper",
                {{"points_log2", "20"},
                 {"cut_bound", "centre"},
                 {"splat", "nearest"},
                 {"warp", "table"},
                 {"hole_fill", "off"},
                 {"backface", "cull"},
                 {"skip_hidden", "off"},
                 {"depth_bits", "8"}}}},
              "paper: the variants of Ritschel et al. 2009");
  }
};

}  // namespace lucarium::micro
