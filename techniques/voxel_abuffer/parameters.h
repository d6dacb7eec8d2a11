// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

enum class Structure { abuffer, voxel, grid, octree, bvh };
enum class ModeChoice { cast, whitted, occlusion, path };
enum class Rebuild { change, frame };
enum class Primary { trace, raster, automatic };

struct AbufferParameters {
  ModeChoice mode = ModeChoice::path;
  Structure structure = Structure::abuffer;
  int abuffer_size = 1280, grid_size = 0;
  Intersect intersect = Intersect::exact;
  Search search = Search::columns;
  AxisRule axis_rule = AxisRule::absolute_normal;
  int bisect = 10;
  float offset_h = 1;
  Attributes attributes = Attributes::triangle;
  LayeredVariant list = LayeredVariant::tiles;
  bool conservative_voxels = true, static_set = false, count_work = false;
  int depth = 3;
  float ambient = 0, ao_radius = -1;
  int lambda = 1, passes = 0;
  bool progressive = true;
  Rebuild rebuild = Rebuild::change;
  Primary primary = Primary::trace;

  template <class V>
  void describe(V& v) {
    v.choice("mode", mode,
             {{"cast", ModeChoice::cast},
              {"whitted", ModeChoice::whitted},
              {"ao", ModeChoice::occlusion},
              {"path", ModeChoice::path}},
             "ray casting through all surfaces, Whitted's ray tracing, ambient occlusion, or path tracing");
    describe_structure(v);
    v.number("depth", depth, 1, 16, "events", "maximum ideal reflections and refractions along a path (mode=whitted)");
    v.number("ambient", ambient, 0.0f, 1e30f, "cd/m²", "constant light without shadows (mode=whitted)");
    v.number("ao_radius", ao_radius, -1.0f, 1e9f, "m",
             "distance beyond which nothing occludes; -1: a tenth of the scene's longest edge, 0: none");
    v.number("lambda", lambda, 1, 64, "samples/pixel", "samples per pixel in each pass");
    v.number("passes", passes, 0, 1 << 20, "passes", "passes per frame; 0: unlimited");
    v.flag("progressive", progressive, "refine the image until something changes; off: start over with every frame");
    v.choice("rebuild", rebuild, {{"change", Rebuild::change}, {"frame", Rebuild::frame}},
             "when the structure is built: after changes of geometry, or for every frame");
    v.choice("primary", primary, {{"trace", Primary::trace}, {"raster", Primary::raster}, {"auto", Primary::automatic}},
             "first hits of camera rays: traced, rasterized for pixel centres only, or rasterized where that is "
             "possible (auto)");
    v.presets({{"paper",
                {{"intersect", "parity"},
                 {"search", "3"},
                 {"axis_rule", "average"},
                 {"attributes", "stored"},
                 {"list", "linked"},
                 {"conservative_voxels", "off"},
                 {"rebuild", "frame"},
                 {"primary", "auto"},
                 {"abuffer_size", "1280"},
                 {"grid_size", "64"}}}},
              "set of values; paper: the choices of Hu et al. 2014");
    v.basic({"preset", "mode", "structure", "abuffer_size", "grid_size", "intersect", "search", "depth", "ao_radius",
             "lambda", "passes"});
  }

  template <class V>
  void describe_structure(V& v) {
    v.choice(
        "structure", structure,
        {{"abuffer", Structure::abuffer},
         {"voxel", Structure::voxel},
         {"grid", Structure::grid},
         {"octree", Structure::octree},
         {"bvh", Structure::bvh}},
        "structure that rays are traced through: A-buffers, or, to compare with, occupied voxels, triangles in voxels, "
        "a sparse octree, or a bounding-volume hierarchy");
    v.number("abuffer_size", abuffer_size, 128, 4096, "pixels",
             "pixels along an edge of an A-buffer; with structure=voxel and octree voxels along it");
    v.number(
        "grid_size", grid_size, 0, 2048, "voxels",
        "voxels along the scene's longest edge, 16 or more; 0: the square root of 3 abuffer_size, or for A-buffers "
        "with intersect=exact abuffer_size / 8, 256 at most");
    v.choice(
        "intersect", intersect,
        {{"auto", Intersect::automatic},
         {"parity", Intersect::parity},
         {"plane", Intersect::plane},
         {"exact", Intersect::exact}},
        "how hits are found: by triangles of fragments (exact), where inside changes to outside (parity), by planes of "
        "fragments (plane), or by parity for closed components alone (auto)");
    v.choice("search", search, {{"2d", Search::columns}, {"3", Search::three_steps}, {"1", Search::one_step}},
             "search by parity in a voxel: all columns (2d), or 3 steps or 1 step along the ray, then bisection");
    v.choice(
        "axis_rule", axis_rule, {{"absnormal", AxisRule::absolute_normal}, {"average", AxisRule::average_normal}},
        "axis of the A-buffer that is searched in a voxel: by the sum of |n| over its surface, or by the average of n");
    v.number("bisect", bisect, 4, 16, "steps", "bisection steps of search=3 and search=1");
    v.number("offset_h", offset_h, 0.5f, 4.0f, "pixels",
             "distance from surfaces at which rays begin and end in search by parity");
    v.choice("attributes", attributes,
             {{"triangle", Attributes::triangle}, {"pixel", Attributes::pixel}, {"stored", Attributes::stored}},
             "attributes of hits by parity and planes: of the point where the ray meets the triangle, of the pixel's "
             "centre, "
             "or the latter stored with each fragment (stored, 32 bytes)");
    v.choice(
        "list", list,
        {{"tiles", LayeredVariant::tiles}, {"counted", LayeredVariant::exact}, {"linked", LayeredVariant::linked_list}},
        "how lists of fragments are built, with equal results: in tiles, counted first, or as linked lists");
    v.flag("conservative_voxels", conservative_voxels,
           "search all voxels that triangles touch; off: only those that hold fragments (paper)");
    v.flag("static_set", static_set,
           "build a separate structure of what no animation moves, so that motions rebuild the rest only");
    v.flag("count_work", count_work, "count lengths of lists and steps of rays; takes time");
  }
};

}  // namespace lucarium::abuffer
