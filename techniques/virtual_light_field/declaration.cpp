// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/declaration.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "lucarium/base/error.h"
#include "virtual_light_field/base/plan.h"
#include "virtual_light_field/field/light_field.h"

namespace lucarium::vlf {
namespace {

/// Whether a point of the material is a mirror or clear glass, at the smoothest texel of its texture.
bool is_ideal_somewhere(const Scene& scene, SceneMaterial material) {
  const int texture = std::exchange(material.metallic_roughness_texture, {}).texture;
  if (texture >= 0) {
    const std::vector<uint8_t>& rgba = scene.images[scene.textures[texture].image].rgba;
    int least = 255;
    for (size_t green = 1; green < rgba.size(); green += 4) least = std::min(least, int{rgba[green]});
    material.roughness *= static_cast<float>(least) / 255;
  }
  return material.may_be_ideal();
}

}  // namespace

TechniqueInfo technique_info() {
  TechniqueInfo info;
  info.name = "virtual_light_field";
  info.version = "1.2";
  info.summary = "light field along fixed directions, propagated once and looked up in constant time";
  info.citation =
      "J. Mortensen, P. Khanna, M. Slater, Light Field Propagation and Rendering on the GPU, AFRIGRAPH 2007";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.max_bounces = -1;
  info.capabilities.view_independent = true;
  info.capabilities.resizes = true;
  info.capabilities.bias = 0.03;  // mirror light is blurred by the spacing of directions, all light by cells and texels
  info.layers = {"emission", "direct", "indirect", "subfield"};
  info.check_parameters = {{"dir_n", "8"}, {"cells", "32"}, {"texels", "8192"}};  // coarser, refraction is off by 2.2 %
  info.oclgrind_parameters = {
      {"dir_n", "2"}, {"cells", "16"}, {"texels", "256"}, {"supersample", "1"}, {"access_rays", "128"}};
  return info;
}

PathSet path_set(const Parameters& parameters, const Scene&, const RenderSettings& settings) {
  PathSet set;
  set.max_bounces = settings.max_bounces;
  set.secondary_lambert_only = parameters.weak_lobes == WeakLobes::drop && parameters.tile_albedo >= 1;
  return set;
}

void check_parameters(const Parameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const bool ideal = std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [&](const SceneMaterial& m) { return is_ideal_somewhere(scene, m); });
  if (parameters.eye_specular == EyeLobes::vlf && settings.max_bounces >= 0 && ideal)
    throw Error(ErrorClass::usage,
                "virtual_light_field: with eye_specular=vlf a mirror before the eye counts as a bounce; leave "
                "--max-bounces unlimited, or set eye_specular=trace");
  if (parameters.eye_direct == EyeDirect::atlas && !parameters.split_layers)
    throw Error(ErrorClass::usage,
                "virtual_light_field: eye_direct=atlas needs the direct light of tiles; set split_layers=on");
  if (parameters.cells > 0 && parameters.cells < static_cast<int>(kMinSubfield))
    throw_error(ErrorClass::usage, "virtual_light_field: cells={}: give at least {}, or 0 for an automatic choice",
                parameters.cells, kMinSubfield);
  if (parameters.inspect_line > 2 * parameters.dir_n * parameters.dir_n)
    throw_error(ErrorClass::usage, "virtual_light_field: inspect_line={} with dir_n={}: lines are 0 to {}",
                parameters.inspect_line, parameters.dir_n, 2 * parameters.dir_n * parameters.dir_n);
  if (!parameters.split_layers && parameters.eye_glossy == EyeLobes::vlf)
    throw Error(ErrorClass::usage,
                "virtual_light_field: eye_glossy=vlf needs the direct light of tiles apart; set split_layers=on");
}

std::vector<std::string> limitations(const Parameters& parameters, const Scene& scene, const RenderSettings& settings) {
  std::vector<std::string> list;
  const Plan plan = make_plan(parameters, scene, settings);
  if (plan.traced && !scene.lights.empty() && parameters.eye_direct == EyeDirect::atlas)
    list.push_back("point, spot and directional lights make no highlights (eye_direct=atlas with eye_glossy=trace)");
  if (plan.lobes && scene.lights.size() > CellScatter::kMaxLights)
    list.push_back(fmt::format("{} of {} point, spot and directional lights make no highlights on rough metal",
                               scene.lights.size() - CellScatter::kMaxLights, scene.lights.size()));
  if (plan.lobes && parameters.scatter == ScatterMode::splat_raw)
    list.push_back("light by mirrors and glass is uneven: its power is kept, not its radiance (scatter=splat_raw)");
  if (plan.field && settings.max_bounces < 0 && !parameters.tail)
    list.push_back("unlimited bounces end early, without what is missing (tail=off)");
  if (parameters.weak_lobes == WeakLobes::drop && plan.lobes && parameters.tile_albedo < 1)
    list.push_back("specular lobes below tile_albedo scatter no light on (weak_lobes=drop)");
  return list;
}

}  // namespace lucarium::vlf
