// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/surface_atlas/most_texels.h"
#include "lucarium/technique/parameters.h"

namespace lucarium::vlf {

enum class DirectMode { nee, exchange };
enum class WeakLobes { fold, drop };
enum class EyeDirect { samples, atlas };
enum class EyeLobes { trace, vlf };
enum class EyeInterpolation { bary, nearest };
enum class SendInterpolation { bary, cell };
enum class ScatterMode { gather, splat, splat_raw };  // in the order of splat_lobes.clh
enum class Store { tiles, csr };
enum class Supersample { automatic, one, two, four, eight };

/// Every parameter of the technique, once: default, range, unit and meaning.
struct Parameters {
  int dir_n = 16;
  int cells = 0;
  int tile = 8;
  int dir_levels = 0;
  int texels = 0;
  float pixel_size = 0.5f;
  float access_gap = -1;
  int access_rays = 256;
  Supersample supersample = Supersample::automatic;
  int perturb = 1;
  SendInterpolation send_interp = SendInterpolation::bary;
  float residual = 0.005f;
  bool tail = true;
  ScatterMode scatter = ScatterMode::gather;
  DirectMode direct_mode = DirectMode::nee;
  bool split_layers = true;
  float tile_albedo = 0.1f;
  WeakLobes weak_lobes = WeakLobes::fold;
  EyeDirect eye_direct = EyeDirect::samples;
  EyeLobes eye_specular = EyeLobes::trace;
  EyeLobes eye_glossy = EyeLobes::trace;
  EyeInterpolation eye_interp = EyeInterpolation::bary;
  float patch_cone = 30;
  Store store = Store::tiles;
  bool preview = true;
  int cache_visibility = 512;
  int inspect_line = -1;
  int camera_samples = 64;

  template <class V>
  void describe(V& v) {
    v.number("dir_n", dir_n, 2, 64, "",
             "subdivision n of the direction grid: light travels along 2 n^2 + 1 lines, both ways (paper: 512, 2k)");
    v.number("cells", cells, 0, 2048, "cells",
             "cells per edge of a line's subfield, at least 16; 0: from the spacing of directions and the size of the "
             "scene, 64 to 256");
    v.number("tile", tile, 0, 32, "cells", "edge length of tiles; 0: chosen for each patch (paper: 8, 16)");
    v.number("dir_levels", dir_levels, 0, 3, "",
             "halvings of dir_n, at most, for rough surfaces whose lobes are as wide as the spacing of directions then "
             "is: a quarter of the cells each");
    v.number("texels", texels, 0, kMaxAtlasTexels, "texels",
             "target size of the surface atlas; 0: eight per pixel, or one for four triangles if that is more; "
             "at least 32768 and at most 262144");
    v.number("pixel_size", pixel_size, 0.1f, 2.f, "texel edges",
             "maximum edge length of a pixel of a subfield, with supersample=auto");
    v.number("access_gap", access_gap, -1.f, 16.f, "texel edges",
             "longer rays are free, which weights texel parts, and parts closer under glass are kept apart; "
             "0: neither; -1: 8, up to a tenth of the scene, under glass 2");
    v.number("access_rays", access_rays, 128, 4096, "rays", "rays per texel that measure its accessibility");
    v.choice("supersample", supersample,
             {{"auto", Supersample::automatic},
              {"1", Supersample::one},
              {"2", Supersample::two},
              {"4", Supersample::four},
              {"8", Supersample::eight}},
             "pixels per edge of a cell; auto: as pixel_size says");
    v.number("perturb", perturb, 1, 256, "",
             "jittered copies of each direction, propagated in turn; time grows with them, memory does not (paper: 1, "
             "36)");
    v.choice(
        "send_interp", send_interp, {{"bary", SendInterpolation::bary}, {"cell", SendInterpolation::cell}},
        "what specular surfaces send with perturb above 1: interpolated between three directions (bary), or the value "
        "of the cell (cell, paper)");
    v.number("residual", residual, 0.f, 1.f, "",
             "relative error at which propagation of unlimited bounces stops; 0: never");
    v.flag("tail", tail, "add the bounces that are missing when propagation ends as a geometric series (paper: off)");
    v.choice(
        "scatter", scatter,
        {{"gather", ScatterMode::gather}, {"splat", ScatterMode::splat}, {"splat_raw", ScatterMode::splat_raw}},
        "ideal lobes: each direction gathers (gather), or each spreads over three, with weights normalised (splat) "
        "or not (splat_raw, paper)");
    v.choice("direct_mode", direct_mode, {{"nee", DirectMode::nee}, {"exchange", DirectMode::exchange}},
             "direct light of emissive surfaces and the environment: light samples (nee) or propagation (exchange, "
             "paper)");
    v.flag("split_layers", split_layers,
           "store direct light of tiles separately, 4 bytes per cell; eye_direct needs it");
    v.number("tile_albedo", tile_albedo, 0.f, 1.f, "",
             "minimum specular albedo and transmission of surfaces that keep radiance by direction");
    v.choice("weak_lobes", weak_lobes, {{"fold", WeakLobes::fold}, {"drop", WeakLobes::drop}},
             "specular lobes below tile_albedo: added to the diffuse albedo in propagation (fold), or left out (drop)");
    v.choice("eye_direct", eye_direct, {{"samples", EyeDirect::samples}, {"atlas", EyeDirect::atlas}},
             "direct light at pixels: light samples, or the atlas (paper)");
    v.choice("eye_specular", eye_specular, {{"trace", EyeLobes::trace}, {"vlf", EyeLobes::vlf}},
             "mirrors and glass at pixels: followed to what they show (trace), or the tiles of the first surface (vlf, "
             "paper)");
    v.choice("eye_glossy", eye_glossy, {{"trace", EyeLobes::trace}, {"vlf", EyeLobes::vlf}},
             "specular lobes at pixels: a ray that looks up where it ends (trace), or the tiles (vlf, paper)");
    v.choice("eye_interp", eye_interp, {{"bary", EyeInterpolation::bary}, {"nearest", EyeInterpolation::nearest}},
             "directions that a look-up of tiles mixes: the three around it (bary), or the nearest");
    v.number("patch_cone", patch_cone, 0.f, 60.f, "degrees",
             "maximum angle between normals of a patch and that of its largest triangle; 0: planar patches (paper)");
    v.choice("store", store, {{"tiles", Store::tiles}, {"csr", Store::csr}},
             "cells of a surface on a subfield: square tiles (tiles, paper), or rows of cells from edge to edge (csr)");
    v.number("cache_visibility", cache_visibility, 0, 1 << 20, "MiB",
             "memory for fragments of subfields that are kept from sweep to sweep (paper: sorted lists); 0: none");
    v.flag("preview", preview,
           "show diffuse light of few bounces along few lines until better is known; with direct_mode=nee");
    v.number("inspect_line", inspect_line, -1, 8192, "",
             "line that the layer subfield shows, 0 to 2 n^2: what leaves the scene along it; -1: none");
    v.number("camera_samples", camera_samples, 0, 1 << 24, "samples",
             "minimum samples per pixel before the image counts as converged; 0: it never does");
    v.presets({{"paper",
                {{"send_interp", "cell"},
                 {"tail", "off"},
                 {"scatter", "splat_raw"},
                 {"direct_mode", "exchange"},
                 {"access_gap", "0"},
                 {"eye_direct", "atlas"},
                 {"eye_specular", "vlf"},
                 {"eye_glossy", "vlf"},
                 {"patch_cone", "0"},
                 {"preview", "off"}}},
               {"walkthrough",
                {{"eye_direct", "atlas"}, {"eye_specular", "vlf"}, {"eye_glossy", "vlf"}, {"camera_samples", "1"}}}},
              "set of values; paper: the choices of Mortensen et al. 2007; walkthrough: frames of constant time");
    v.basic({"dir_n", "cells", "texels", "residual", "direct_mode", "eye_direct", "eye_glossy", "camera_samples"});
  }
};

}  // namespace lucarium::vlf
