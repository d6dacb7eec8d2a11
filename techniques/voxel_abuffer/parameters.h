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
    v.number("depth", depth, 1, 16, "events", "most ideal reflections and refractions of mode=whitted");
    v.number("ambient", ambient, 0.0f, 1e30f, "cd/m²", "constant light without shadows of mode=whitted");
    v.number("ao_radius", ao_radius, -1.0f, 1e9f, "m",
             "distance beyond which nothing occludes; -1: a tenth of the scene's longest edge, 0: none");
    v.number("lambda", lambda, 1, 64, "samples/pixel", "samples per pixel and pass");
    v.number("passes", passes, 0, 1 << 20, "passes", "passes of a frame; 0: without end");
    v.flag("progressive", progressive, "refine the image until something changes; off: begin every frame again");
    v.choice("rebuild", rebuild, {{"change", Rebuild::change}, {"frame", Rebuild::frame}},
             "build the structure when geometry has changed, or for every frame");
    v.choice("primary", primary, {{"trace", Primary::trace}, {"raster", Primary::raster}, {"auto", Primary::automatic}},
             "what pixels see first: by rays, or rasterized, at their centres only; auto: rasterized where it can be");
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
              "values of Hu et al. 2014");
    v.basic({"preset", "mode", "structure", "abuffer_size", "grid_size", "intersect", "search", "depth", "ao_radius",
             "lambda", "passes"});
  }

  template <class V>
  void describe_structure(V& v) {
    v.choice("structure", structure,
             {{"abuffer", Structure::abuffer},
              {"voxel", Structure::voxel},
              {"grid", Structure::grid},
              {"octree", Structure::octree},
              {"bvh", Structure::bvh}},
             "what rays are traced through: A-buffers, or to compare with, occupied voxels, triangles in voxels, a "
             "sparse octree, a bounding-volume hierarchy");
    v.number("abuffer_size", abuffer_size, 128, 4096, "pixels",
             "pixels along an edge of an A-buffer; for structure=voxel and octree their voxels along it");
    v.number("grid_size", grid_size, 0, 2048, "voxels",
             "voxels along the scene's longest edge, 16 or more; 0: the square root of 3 abuffer_size");
    v.choice("intersect", intersect,
             {{"auto", Intersect::automatic},
              {"parity", Intersect::parity},
              {"plane", Intersect::plane},
              {"exact", Intersect::exact}},
             "where surfaces are found: between inside and outside (parity), by planes of fragments (plane), by their "
             "triangles (exact), or closed components by parity and open ones exactly (auto)");
    v.choice("search", search, {{"2d", Search::columns}, {"3", Search::three_steps}, {"1", Search::one_step}},
             "search for parity: all columns of a voxel, or points 3 or 1 steps apart and bisection");
    v.choice("axis_rule", axis_rule, {{"absnormal", AxisRule::absolute_normal}, {"average", AxisRule::average_normal}},
             "A-buffer in which a voxel is searched: by the sum of its normals' absolute values, or their average");
    v.number("bisect", bisect, 4, 16, "steps", "bisection steps of search=3 and search=1");
    v.number("offset_h", offset_h, 0.5f, 4.0f, "pixels", "distance off surfaces at which parity rays begin and end");
    v.choice(
        "attributes", attributes,
        {{"triangle", Attributes::triangle}, {"pixel", Attributes::pixel}, {"stored", Attributes::stored}},
        "attributes of hits by parity and planes: where the ray meets the triangle, or those of the pixel's centre; "
        "stored: the same from 32 bytes per fragment");
    v.choice(
        "list", list,
        {{"tiles", LayeredVariant::tiles}, {"counted", LayeredVariant::exact}, {"linked", LayeredVariant::linked_list}},
        "way to the lists of fragments: inside tiles, counted before, or linked; the same lists");
    v.flag("conservative_voxels", conservative_voxels,
           "rays look into all voxels that triangles touch; off: into those that hold fragments");
    v.flag("static_set", static_set,
           "what no animation moves has a structure of its own, which motions leave as it is");
    v.flag("count_work", count_work, "counters of lengths of lists and of the steps of rays; takes time");
  }
};

}  // namespace lucarium::abuffer
