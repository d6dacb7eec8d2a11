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
  bool gather_visible = true;
  int photons = 1000000;
  int photon_k = 50;
  bool photon_direct = false;
  int light_samples = 8;
  int direct_samples = 4;
  float eye_share = -1;
  int unlimited_bounces = 4;
  int batch_gathers = 4096;
  int inspect_x = -1, inspect_y = -1;

  /// Longest edge of a micro-buffer.
  int largest_edge() const { return adaptive > 0 ? std::min(64, micro_size * 3 / 2) : micro_size; }
  /// Whether gathers at pixels know what the frames before have found.
  bool keeps_levels() const { return cut_error > 0 || adaptive > 0; }

  /// cut_kappa of gathers at nodes. They are few, and what they err by is in all pixels: a coarse cut is for pixels
  /// only.
  float node_kappa() const { return std::min(cut_kappa, 1.f); }

  /// Whether virtual lights light the visible points themselves.
  bool shows_virtual_lights() const { return !gather_visible && multibounce == MultiBounce::instant_radiosity; }

  template <class V>
  void describe(V& v) {
    v.number("points_log2", points_log2, 10, 23, "log2",
             "number of points on the surfaces, the leaves of the hierarchy");
    v.number("micro_size", micro_size, 8, 64, "micro-pixels", "edge length of a micro-buffer");
    v.number("cut_kappa", cut_kappa, 0.25f, 4, "micro-pixels",
             "solid angle above which a node is split; at nodes at most 1");
    v.choice("cut_bound", cut_bound, {{"conservative", CutBound::conservative}, {"center", CutBound::centre}},
             "micro-pixel that a node is compared with: the smallest one it covers (conservative), or the one at its "
             "centre");
    v.number("cut_error", cut_error, 0, 1, "",
             "maximum error of a node, relative to the mean of the micro-buffer; splits uneven nodes, coarsens even "
             "cuts; 0: off");
    v.choice("splat", splat, {{"sample", Splat::sample}, {"nearest", Splat::nearest}},
             "micro-pixels that a node covers: those whose sample direction hits its disc (sample), or the one at its "
             "centre");
    v.number("splat_radius", splat_radius, 0.8f, 1.7f, "", "radius of a splat, relative to a disc of the node's area");
    v.number("disc_scale", disc_scale, 1, 2.2f, "", "radius of a leaf's disc, relative to a disc of the leaf's area");
    v.choice("warp", warp, {{"analytic", Warp::analytic}, {"table", Warp::table}, {"nusselt", Warp::nusselt}},
             "projection of micro-buffers: by analytic maps of the lobes, by tables of the BSDF, or to the unit disc "
             "(nusselt)");
    v.number("table_size", table_size, 8, 64, "cells", "edge length of the BSDF tables (warp=table)");
    v.flag("hole_fill", hole_fill, "fill empty micro-pixels between covered ones with the mean of their neighbours");
    v.flag("raycast", raycast, "ray-cast leaves that are larger than a micro-pixel as discs");
    v.flag("morton", morton, "gather in Morton order of the points instead of pixel order");
    v.choice("backface", backface, {{"black", Backface::black}, {"cull", Backface::cull}},
             "back of single-sided surfaces: black, as in the reference, or transparent (cull)");
    v.flag("skip_hidden", skip_hidden,
           "place no points on surfaces inside other solids; backs that nothing else sees become transparent");
    v.number("adaptive", adaptive, 0, 1, "",
             "relative deviation between frames above which, or where interpolation fails, a micro-buffer becomes 1.5 "
             "times as wide, at most 64; 0: off");
    v.number(
        "gather_step", gather_step, 1, 8, "pixels",
        "gather at every n-th pixel of every n-th row and interpolate the others; above 1 a frame is one iteration");
    v.number("upsample_fail", upsample_fail, 0, 1, "",
             "minimum sum of bilateral weights; pixels below it are gathered; 0: always interpolate");
    v.flag("gather_env", gather_env, "empty micro-pixels see the environment; direct light leaves it out");
    v.choice("node_shading", node_shading, {{"stored", NodeShading::stored}, {"dynamic", NodeShading::dynamic}},
             "light that nodes reflect: diffuse, stored in advance (stored), or glossy too, computed for each gather "
             "(dynamic)");
    v.choice(
        "multibounce", multibounce,
        {{"jacobi", MultiBounce::jacobi},
         {"instant_radiosity", MultiBounce::instant_radiosity},
         {"photon_map", MultiBounce::photon_map}},
        "how light of several bounces reaches the points: by gathers at nodes (jacobi), virtual lights, or photons");
    v.number("jacobi_level", jacobi_level, 6, 23, "log2",
             "level of the nodes that gather for all bounces before the last");
    v.number("jacobi_cone", jacobi_cone, 1, 180, "degrees",
             "half angle of the normal cone above which the descendants of a node gather instead; at most twice the "
             "gathers");
    v.number("vpls", vpls, 1, 65536, "paths",
             "light paths of instant radiosity, each with one virtual light per bounce");
    v.number("vpl_clamp", vpl_clamp, 0.01f, 1e6f, "1/R²",
             "maximum geometry term of a virtual light; R is the scene's radius");
    v.flag("gather_visible", gather_visible,
           "gather at visible points; off: virtual lights light their diffuse lobes (multibounce=instant_radiosity)");
    v.number("photons", photons, 1000, 1 << 24, "paths", "light paths of the photon map");
    v.number("photon_k", photon_k, 4, 256, "photons", "photons per density estimate");
    v.flag("photon_direct", photon_direct, "take direct light at points from photons instead of light samples");
    v.choice("depth_bits", depth_bits, {{"8", DepthBits::eight}, {"32", DepthBits::thirty_two}},
             "bits per depth value of a micro-buffer");
    v.number("light_samples", light_samples, 1, 1024, "samples/point", "light samples per point and frame");
    v.number("direct_samples", direct_samples, 1, 1024, "samples/pixel", "samples of direct light per pixel and frame");
    v.number("eye_share", eye_share, -1.f, 0.9f, "",
             "share of the work that goes to further samples of pixels, which bring emission and direct light; 0: one "
             "for each frame, -1: by the measured variances of both");
    v.number("unlimited_bounces", unlimited_bounces, 1, 32, "bounces",
             "bounces computed when max_bounces is unlimited");
    v.number("batch_gathers", batch_gathers, 64, 1 << 24, "gathers",
             "maximum gathers per iteration; lighting the points is split into iterations of about the same cost");
    v.number("inspect_x", inspect_x, -1, 1 << 15, "pixels",
             "column of the pixel whose micro-buffer the layer micro_buffer shows; -1: none");
    v.number("inspect_y", inspect_y, -1, 1 << 15, "pixels",
             "row of the pixel whose micro-buffer the layer micro_buffer shows; -1: none");
    v.presets({{"paper",
                {{"points_log2", "20"},
                 {"cut_bound", "center"},
                 {"splat", "nearest"},
                 {"warp", "table"},
                 {"hole_fill", "off"},
                 {"backface", "cull"},
                 {"skip_hidden", "off"},
                 {"depth_bits", "8"},
                 {"eye_share", "0"}}}},
              "set of values; paper: the choices of Ritschel et al. 2009");
    v.basic({"points_log2", "micro_size", "light_samples", "direct_samples", "eye_share", "gather_step", "multibounce",
             "unlimited_bounces", "cut_error", "adaptive", "skip_hidden", "gather_env", "node_shading"});
  }
};

}  // namespace lucarium::micro
