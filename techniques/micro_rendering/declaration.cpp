// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/declaration.h"

#include <fmt/format.h>

#include <algorithm>

#include "lucarium/services/eye_light/eye_light.h"
#include "micro_rendering/light/leaf_light.h"
#include "micro_rendering/pixels/pixel_gather.h"
#include "micro_rendering/tree/scene_forest.h"

namespace lucarium::micro {

TechniqueInfo technique_info() {
  TechniqueInfo info;
  info.name = "micro_rendering";
  info.version = "1.0";
  info.summary = "final gathering by rendering a hierarchy of discs into BRDF-warped micro-buffers";
  info.citation =
      "T. Ritschel, T. Engelhardt, T. Grosch, H.-P. Seidel, J. Kautz and C. Dachsbacher, Micro-Rendering for Scalable, "
      "Parallel Final Gathering, SIGGRAPH Asia 2009";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.resizes = true;
  info.capabilities.bias = 0.02;
  info.capabilities.pixel_sampling = {};
  for (uint32_t mode = 0; mode <= 16; ++mode) info.capabilities.pixel_sampling.push_back(mode);
  info.layers = {"emission", "direct", "indirect", "cut_level", "list_length", "node_visits"};
  info.optional_layers = {{"gather_step above 1", {"upsampling_failed"}},
                          {"inspect_x and inspect_y", {"micro_buffer"}}};
  info.pixel_layer = {"inspect_x", "inspect_y", "micro_buffer"};
  info.check_parameters = {{"points_log2", "12"}, {"micro_size", "8"}, {"jacobi_level", "6"}, {"light_samples", "2"}};
  // Without the walks that find hidden points, which are a service of the framework with tests of its own.
  info.oclgrind_parameters = {{"points_log2", "10"}, {"light_samples", "1"}, {"skip_hidden", "off"}};
  return info;
}

int bounces(const MicroParameters& parameters, const RenderSettings& settings) {
  return settings.max_bounces < 0 ? parameters.unlimited_bounces : settings.max_bounces;
}

bool transmits(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
    return m.transmission > 0 && m.roughness >= LUCARIUM_MIRROR_ROUGHNESS;
  });
}

PathSet path_set(const MicroParameters& parameters, const RenderSettings& settings) {
  PathSet set;
  set.max_bounces = bounces(parameters, settings);
  set.indirect = set.max_bounces > 0;
  set.light_delta = false;
  // Of several bounces only the last one before the eye's is glossy: no path set says so.
  const bool glossy_nodes = parameters.node_shading == NodeShading::dynamic &&
                            !(parameters.multibounce == MultiBounce::photon_map && parameters.photon_direct);
  set.secondary_lambert_only = !glossy_nodes || set.max_bounces > 1;
  return set;
}

std::vector<std::string> limitations(const MicroParameters& parameters, const Scene& scene,
                                     const RenderSettings& settings) {
  std::vector<std::string> list;
  if (settings.max_bounces < 0)
    list.push_back(fmt::format("limits paths to {} bounces (unlimited_bounces)", bounces(parameters, settings)));
  const bool ideal = std::any_of(scene.materials.begin(), scene.materials.end(), [](const SceneMaterial& m) {
    return m.transmission > 0 || m.roughness < LUCARIUM_MIRROR_ROUGHNESS;
  });
  if (parameters.node_shading == NodeShading::dynamic && bounces(parameters, settings) > 1)
    list.push_back(
        "node_shading=dynamic: with several bounces only the second vertex from the eye is glossy, and only for light "
        "samples and virtual lights");
  if (parameters.multibounce == MultiBounce::instant_radiosity &&
      (bounces(parameters, settings) > 1 || parameters.shows_virtual_lights()))
    list.push_back("virtual lights' geometry term is bounded by vpl_clamp: corners are too dark");
  if (parameters.multibounce == MultiBounce::photon_map &&
      (bounces(parameters, settings) > 1 || parameters.photon_direct))
    list.push_back("the photon map blurs light over photon_k photons");
  if (parameters.node_shading == NodeShading::dynamic && parameters.multibounce == MultiBounce::photon_map &&
      parameters.photon_direct)
    list.push_back("node_shading=dynamic has no effect: photons stand for light samples (photon_direct=on)");
  if (parameters.shows_virtual_lights())
    list.push_back("gather_visible=off: visible surfaces reflect indirect light by their diffuse lobes only");
  if (!parameters.gather_visible && !parameters.shows_virtual_lights())
    list.push_back("gather_visible=off has no effect without multibounce=instant_radiosity");
  if (parameters.adaptive > 0 && parameters.largest_edge() < parameters.micro_size * 3 / 2)
    list.push_back(fmt::format("adaptive: enlarged micro-buffers have edges of {} micro-pixels, not {}",
                               parameters.largest_edge(), parameters.micro_size * 3 / 2));
  const bool inspects = parameters.inspect_x >= 0 || parameters.inspect_y >= 0;
  const auto inside = [](int at, uint32_t size) { return at >= 0 && static_cast<uint32_t>(at) < size; };
  if (inspects && !(inside(parameters.inspect_x, settings.width) && inside(parameters.inspect_y, settings.height)))
    list.push_back(fmt::format("no micro-buffer is shown: inspect_x={}, inspect_y={} is not a pixel of {}×{}",
                               parameters.inspect_x, parameters.inspect_y, settings.width, settings.height));
  else if (inspects && (bounces(parameters, settings) == 0 || parameters.shows_virtual_lights()))
    list.push_back("no micro-buffer is shown: nothing is gathered (inspect_x, inspect_y)");
  if (parameters.backface == Backface::cull)
    list.push_back("backs of single-sided surfaces let light through; in the reference they block it (backface=cull)");
  if (ideal)
    list.push_back(
        "only the camera sees mirrors and glass: no caustics, no reflections in reflections of rough surfaces");
  return list;
}

size_t estimate_bytes(const MicroParameters& parameters, const Scene& scene, const RenderSettings& settings) {
  const size_t pixels = size_t{settings.width} * settings.height;
  size_t bytes = EyeLight::estimate_bytes(settings.width, settings.height);
  if (bounces(parameters, settings) == 0) return bytes;
  const PointForest::Size forest = PointForest::estimate(scene, forest_options(parameters));
  if (parameters.shows_virtual_lights())
    bytes += PathLight::estimate_bytes(parameters, pixels, bounces(parameters, settings) + 1);
  return bytes + forest.bytes + LeafLight::estimate_bytes(parameters, forest.leaves, bounces(parameters, settings)) +
         PixelGather::estimate_bytes(settings.width, settings.height, parameters, transmits(scene));
}

}  // namespace lucarium::micro
