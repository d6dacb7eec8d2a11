// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/declaration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/modes/eye_trees.h"
#include "voxel_abuffer/modes/occlusion_mode.h"
#include "voxel_abuffer/modes/path_mode.h"
#include "voxel_abuffer/modes/primary_raster.h"
#include "voxel_abuffer/scene_structure.h"
#include "voxel_abuffer/structure/grid_layout.h"

namespace lucarium::abuffer {

namespace {

constexpr double max_bias = 0.5;

GridSize grid_of(const AbufferParameters& parameters) {
  return choose_grid_size(static_cast<uint32_t>(parameters.abuffer_size), static_cast<uint32_t>(parameters.grid_size));
}

/// Parameters that were set and that others leave without effect: a line per reason.
void list_idle_parameters(const AbufferParameters& parameters, std::vector<std::string>& list) {
  const AbufferParameters usual;
  const bool abuffer = parameters.structure == Structure::abuffer;
  const bool grid = abuffer || parameters.structure == Structure::grid;
  const bool bvh = parameters.structure == Structure::bvh;
  const bool planes = abuffer && parameters.intersect == Intersect::plane;
  const bool parity = abuffer && !planes && parameters.intersect != Intersect::exact;
  const bool whitted = parameters.mode == ModeChoice::whitted, occlusion = parameters.mode == ModeChoice::occlusion;
  const bool search_is_set = parameters.search != usual.search, axis_is_set = parameters.axis_rule != usual.axis_rule;
  const bool bisect_is_set = parameters.bisect != usual.bisect, offset_is_set = parameters.offset_h != usual.offset_h;
  const bool attributes_are_set = parameters.attributes != usual.attributes;
  const char* const no_abuffer = "there are no A-buffers (structure)";
  const char* const no_grid = "there is no grid of voxels of its own size (structure)";
  const char* const no_parity = "no hit is found by parity (intersect)";
  const char* const no_parity_or_planes = "no hit is found by parity or planes (intersect)";
  const char* const of_whitted = "it belongs to mode=whitted";
  const struct {
    const char* name;
    bool is_set, has_effect;
    const char* reason;
  } all[] = {
      {"abuffer_size", parameters.abuffer_size != usual.abuffer_size, !bvh, "the hierarchy has no pixels (structure)"},
      {"grid_size", parameters.grid_size != usual.grid_size, grid, no_grid},
      {"intersect", parameters.intersect != usual.intersect, abuffer, no_abuffer},
      {"search", search_is_set, abuffer, no_abuffer},
      {"axis_rule", axis_is_set, abuffer, no_abuffer},
      {"bisect", bisect_is_set, abuffer, no_abuffer},
      {"offset_h", offset_is_set, abuffer, no_abuffer},
      {"attributes", attributes_are_set, abuffer, no_abuffer},
      {"list", parameters.list != usual.list, abuffer, no_abuffer},
      {"conservative_voxels", !parameters.conservative_voxels, abuffer, no_abuffer},
      {"static_set", parameters.static_set, abuffer, no_abuffer},
      {"count_work", parameters.count_work, abuffer, no_abuffer},
      {"search", search_is_set && abuffer, parity, no_parity},
      {"bisect", bisect_is_set && abuffer, parity, no_parity},
      {"offset_h", offset_is_set && abuffer, parity, no_parity},
      {"bisect", bisect_is_set && parity, search_is_set, "all columns are visited (search)"},
      {"axis_rule", axis_is_set && abuffer, parity || planes, no_parity_or_planes},
      {"attributes", attributes_are_set && abuffer, parity || planes, no_parity_or_planes},
      {"depth", parameters.depth != usual.depth, whitted, of_whitted},
      {"ambient", parameters.ambient != usual.ambient, whitted, of_whitted},
      {"ao_radius", parameters.ao_radius != usual.ao_radius, occlusion, "it belongs to mode=ao"},
  };
  std::vector<const char*> names;
  for (size_t i = 0; i < std::size(all); ++i) {
    if (all[i].is_set && !all[i].has_effect) names.push_back(all[i].name);
    if (i + 1 < std::size(all) && all[i + 1].reason == all[i].reason) continue;
    if (!names.empty())
      list.push_back(fmt::format("{} {} no effect: {}", fmt::join(names, ", "), names.size() == 1 ? "has" : "have",
                                 all[i].reason));
    names.clear();
  }
}

}  // namespace

TechniqueInfo technique_info() {
  TechniqueInfo info;
  info.name = technique_name;
  info.version = "1.0";
  info.summary = "ray casting, Whitted's ray tracing, ambient occlusion and path tracing through voxels and A-buffers";
  info.citation =
      "W. Hu, Y. Huang, F. Zhang, G. Yuan and W. Li, Ray tracing via GPU rasterization, The Visual Computer 30, 2014";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.bias = 0.02;
  info.check_parameters = {{"abuffer_size", "256"}};
  info.oclgrind_parameters = {{"abuffer_size", "128"}};
  info.capabilities.uses_bvh = false;  // structure=bvh makes its own
  info.capabilities.pixel_sampling = {};
  for (uint32_t mode = 0; mode <= 16; ++mode) info.capabilities.pixel_sampling.push_back(mode);
  info.layers = {"emission", "direct", "indirect", "ambient", "ambient_occlusion", "crossings"};
  return info;
}

double admitted_bias(const AbufferParameters& parameters, double declared) {
  if (parameters.mode == ModeChoice::occlusion) return 0;  // no light
  if (parameters.structure == Structure::bvh || parameters.structure == Structure::grid) return 0;
  if (parameters.structure != Structure::abuffer) return max_bias;  // surfaces as thick as a voxel
  if (parameters.intersect == Intersect::exact) return parameters.conservative_voxels ? 0 : declared;
  // Measured with `lucarium check` at 256 and 128 pixels, by all searches alike. Errors are bands along edges as wide
  // as a pixel; hits by parity are where the ray meets a triangle.
  const bool parity = parameters.intersect != Intersect::plane;
  const bool refined = parity && parameters.attributes == Attributes::triangle && parameters.conservative_voxels;
  const double pixel = 1280.0 / parameters.abuffer_size;
  const double pixels = refined ? 0.2 : 0.45;
  return std::min(max_bias, declared * std::max(1.0, pixels * pixel));
}

PathSet path_set(const AbufferParameters& parameters, const RenderSettings& settings) {
  if (parameters.mode == ModeChoice::occlusion) return PathSet::no_light_transport();
  PathSet set;
  set.max_bounces = settings.max_bounces;
  if (parameters.mode == ModeChoice::path) return set;
  set.max_bounces = 0;
  set.indirect = false;
  set.eye_deltas = parameters.mode == ModeChoice::whitted ? parameters.depth : 0;
  return set;
}

std::vector<std::string> limitations(const AbufferParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings) {
  std::vector<std::string> list;
  list_idle_parameters(parameters, list);
  if (parameters.structure == Structure::abuffer && parameters.intersect == Intersect::parity) {
    const uint32_t open = classify(scene, Intersect::parity).open_components;
    if (open > 0)
      list.push_back(fmt::format("intersect=parity: {} no inside; rays find them wrongly",
                                 open == 1 ? "1 open component has" : fmt::format("{} open components have", open)));
  }
  if (parameters.structure == Structure::abuffer && parameters.intersect == Intersect::plane)
    list.push_back("search by planes: surfaces that cover no pixel's centre are not there (intersect)");
  if (parameters.structure == Structure::abuffer &&
      (parameters.intersect == Intersect::parity || parameters.intersect == Intersect::automatic))
    list.push_back("search by parity: surfaces are a pixel off along their edges (intersect)");
  if (parameters.structure == Structure::abuffer && parameters.search != Search::columns &&
      (parameters.intersect == Intersect::parity || parameters.intersect == Intersect::automatic) &&
      !searches_points(grid_of(parameters)))
    list.push_back("search by parity visits all columns: voxels are too small for points along the ray (grid_size)");
  if (parameters.structure == Structure::abuffer && !parameters.conservative_voxels)
    list.push_back("rays pass surfaces in voxels that hold none of their fragments (conservative_voxels)");
  if (parameters.structure == Structure::voxel || parameters.structure == Structure::octree)
    list.push_back("surfaces are as thick as a voxel (structure)");
  const bool ideal = std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& material) {
    return material.transmission > 0 || material.roughness < LUCARIUM_MIRROR_ROUGHNESS;
  });
  if (parameters.mode == ModeChoice::occlusion) {
    list.push_back("mode=ao computes accessibility, not light: errors against a reference of light say nothing of it");
    return list;
  }
  if (parameters.mode != ModeChoice::path && settings.max_bounces != 0)
    list.push_back(
        fmt::format("mode={} computes direct light only", parameters.mode == ModeChoice::cast ? "cast" : "whitted"));
  if (ideal && parameters.mode == ModeChoice::cast)
    list.push_back("mode=cast shows no light of mirrors and clear glass");
  if (ideal && parameters.mode == ModeChoice::whitted)
    list.push_back(fmt::format("a path ends after {} mirrors and refractions (depth)", parameters.depth));
  if (ideal && !scene.lights.empty())
    list.push_back("point, spot and directional light that reaches a surface through a mirror or glass is left out");
  if (parameters.mode == ModeChoice::whitted && parameters.ambient > 0)
    list.push_back("the layer ambient is constant light without shadows, no light transport (ambient)");
  return list;
}

size_t estimate_bytes(const AbufferParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const size_t pixels = size_t{settings.width} * settings.height;
  const size_t rays =
      parameters.mode == ModeChoice::path ? std::min<size_t>(pixels * parameters.lambda, 1u << 20) : pixels;
  const size_t raster =
      rasterizes_primary(parameters, settings)
          ? PrimaryRaster::estimate_bytes(scene.triangle_count(), settings.width, settings.height, rays)
          : 0;
  // Hits of a second set.
  const size_t second = parameters.static_set ? rays * (sizeof(Hit) + sizeof(uint32_t)) : 0;
  const size_t bytes = raster + second + SceneStructure::estimate_bytes(scene, parameters);
  const bool ends = SceneStructure::wants_ends(parameters);
  const auto samples = static_cast<uint32_t>(parameters.lambda);
  switch (parameters.mode) {
    case ModeChoice::path: return bytes + PathMode::estimate_bytes(settings.width, settings.height, samples, ends);
    case ModeChoice::occlusion: return bytes + OcclusionMode::estimate_bytes(settings.width, settings.height, ends);
    default: return bytes + EyeTrees::estimate_bytes(pixels, tree_options(parameters), ends);
  }
}

float occlusion_radius(const AbufferParameters& parameters, const Scene& scene) {
  if (parameters.ao_radius > 0) return parameters.ao_radius;
  const Bounds bounds = scene.bounds();
  if (parameters.ao_radius == 0 || bounds.empty()) return INFINITY;
  const glm::vec3 size = bounds.max - bounds.min;
  return 0.1f * std::max({size.x, size.y, size.z});
}

EyeTrees::Options tree_options(const AbufferParameters& parameters) {
  EyeTrees::Options options;
  options.straight = parameters.mode == ModeChoice::cast;
  options.depth = static_cast<uint32_t>(parameters.depth);
  options.ambient = parameters.mode == ModeChoice::whitted ? parameters.ambient : 0;
  options.samples = static_cast<uint32_t>(parameters.lambda);
  return options;
}

bool rasterizes_primary(const AbufferParameters& parameters, const RenderSettings& settings) {
  return parameters.primary == Primary::raster ||
         (parameters.primary == Primary::automatic && PrimaryRaster::possible(make_frame(settings)));
}

void check_primary(const RenderSettings& settings) {
  if (settings.pixel_sampling != LUCARIUM_PIXEL_CENTRE)
    throw_error(ErrorClass::usage,
                "voxel_abuffer: primary=raster with --pixel-sampling {}: pixels are rasterized at their centres; set "
                "--pixel-sampling center",
                settings.pixel_sampling == LUCARIUM_PIXEL_JITTER ? "jitter" : std::to_string(settings.pixel_sampling));
  if (std::max(settings.width, settings.height) > LAYERED_MAX_EDGE)
    throw_error(ErrorClass::usage, "voxel_abuffer: primary=raster with an image of {}x{} pixels; {} are the most",
                settings.width, settings.height, LAYERED_MAX_EDGE);
  if (!PrimaryRaster::possible(make_frame(settings)))
    throw Error(ErrorClass::usage, "voxel_abuffer: primary=raster with an orthographic camera; set primary=trace");
}

void check_parameters(const AbufferParameters& parameters, const RenderSettings& settings) {
  if (parameters.primary == Primary::raster) check_primary(settings);
  if (!parameters.progressive && parameters.passes == 0)
    throw Error(ErrorClass::usage,
                "voxel_abuffer: progressive=off with passes=0: a frame would never end; set passes to 1 or more");
  if (parameters.grid_size > 0 && parameters.grid_size < 16)
    throw_error(ErrorClass::usage, "voxel_abuffer: grid_size {} is neither 0 nor 16 to 2048", parameters.grid_size);
  if (parameters.ao_radius < 0 && parameters.ao_radius != -1)
    throw_error(ErrorClass::usage, "voxel_abuffer: ao_radius {} is negative and not -1", parameters.ao_radius);
}

}  // namespace lucarium::abuffer
