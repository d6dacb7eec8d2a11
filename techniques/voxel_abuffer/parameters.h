// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::abuffer {

enum class Structure { abuffer, bvh };
enum class ModeChoice { cast, whitted, occlusion, path };
enum class Rebuild { change, frame };

struct AbufferParameters {
  ModeChoice mode = ModeChoice::path;
  Structure structure = Structure::abuffer;
  int abuffer_size = 1280, grid_size = 0;
  LayeredVariant list = LayeredVariant::tiles;
  int depth = 3;
  float ambient = 0, ao_radius = -1;
  int lambda = 1, passes = 0;
  bool progressive = true;
  Rebuild rebuild = Rebuild::change;

  template <class V>
  void describe(V& v) {
    v.choice("mode", mode,
             {{"cast", ModeChoice::cast},
              {"whitted", ModeChoice::whitted},
              {"ao", ModeChoice::occlusion},
              {"path", ModeChoice::path}},
             "ray casting through all surfaces, Whitted's ray tracing, ambient occlusion, or path tracing");
    v.choice("structure", structure, {{"abuffer", Structure::abuffer}, {"bvh", Structure::bvh}},
             "what rays are traced through: grid and A-buffers, or a bounding-volume hierarchy to compare with");
    v.number("abuffer_size", abuffer_size, 128, 4096, "pixels", "pixels along an edge of an A-buffer");
    v.number("grid_size", grid_size, 0, 2048, "voxels",
             "voxels along the scene's longest edge, 16 or more; 0: the square root of 3 abuffer_size");
    v.choice(
        "list", list,
        {{"tiles", LayeredVariant::tiles}, {"counted", LayeredVariant::exact}, {"linked", LayeredVariant::linked_list}},
        "how fragments are stored: inside tiles, counted before, or in linked lists; the same structure");
    v.number("depth", depth, 1, 16, "events", "most ideal reflections and refractions of mode=whitted");
    v.number("ambient", ambient, 0.0f, 1e30f, "cd/m²", "constant light without shadows of mode=whitted");
    v.number("ao_radius", ao_radius, -1.0f, 1e9f, "m",
             "distance beyond which nothing occludes; -1: a tenth of the scene's longest edge, 0: none");
    v.number("lambda", lambda, 1, 64, "samples/pixel", "samples per pixel and pass");
    v.number("passes", passes, 0, 1 << 20, "passes", "passes of a frame; 0: without end");
    v.flag("progressive", progressive, "refine the image until something changes; off: begin every frame again");
    v.choice("rebuild", rebuild, {{"change", Rebuild::change}, {"frame", Rebuild::frame}},
             "build grid and A-buffers when geometry has changed, or for every frame");
    v.basic({"mode", "structure", "abuffer_size", "grid_size", "depth", "ao_radius", "lambda", "passes"});
  }
};

}  // namespace lucarium::abuffer
