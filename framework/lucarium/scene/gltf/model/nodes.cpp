// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/nodes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

namespace lucarium::gltf {

namespace {

glm::vec3 vec3_or(const std::vector<double>& values, glm::vec3 fallback) {
  return values.size() == 3 ? glm::vec3(values[0], values[1], values[2]) : fallback;
}

Node import_node(const tinygltf::Node& source, int parent, size_t index, ImportContext& context) {
  Node node;
  node.name = source.name;
  node.parent = parent;
  node.children = source.children;
  node.translation = vec3_or(source.translation, glm::vec3(0));
  node.scale = vec3_or(source.scale, glm::vec3(1));
  if (source.rotation.size() == 4) {
    const auto& r = source.rotation;
    const glm::dquat rotation(r[3], r[0], r[1], r[2]);
    const double length = glm::length(rotation);
    if (length > 1e-6 && length < 1e30)
      node.rotation = glm::quat(rotation / length);
    else
      context.warn("{}: its rotation has no length and was ignored", label("node", index, source.name));
  }
  if (source.matrix.size() == 16) {
    glm::mat4 matrix(glm::make_mat4(source.matrix.data()));
    if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1) {
      context.warn("{}: its matrix is not affine; the last row was taken as 0 0 0 1",
                   label("node", index, source.name));
      for (int c = 0; c < 4; ++c) matrix[c][3] = c == 3;
    }
    node.matrix = matrix;
  }
  node.in_scene = false;
  return node;
}

/// Roots of the chosen scene.
std::vector<int> scene_roots(const Document& document, ImportContext& context) {
  const int count = static_cast<int>(document.model.scenes.size());
  int chosen = context.options.gltf_scene;
  if (chosen != none && (chosen < 0 || chosen >= count)) {
    context.fail("there is no scene {}; it has {}", chosen, count);
  }
  if (count == 0) {
    std::vector<int> roots;
    for (size_t i = 0; i < document.parents.size(); ++i) {
      if (document.parents[i] == none) roots.push_back(static_cast<int>(i));
    }
    if (!roots.empty()) context.warn("the file has no scene: all its nodes are shown");
    return roots;
  }
  if (chosen == none) {
    chosen = document.model.defaultScene == none ? 0 : document.model.defaultScene;
    if (count > 1) context.warn("the file has {} scenes: scene {} is shown", count, chosen);
  }
  return document.model.scenes[chosen].nodes;
}

}  // namespace

void import_nodes(const Document& document, Scene& scene, ImportContext& context) {
  for (size_t i = 0; i < document.model.nodes.size(); ++i) {
    scene.nodes.push_back(import_node(document.model.nodes[i], document.parents[i], i, context));
  }
  std::vector<int> pending = scene_roots(document, context);
  while (!pending.empty()) {
    Node& node = scene.nodes[pending.back()];
    pending.pop_back();
    if (node.in_scene) continue;  // a root listed twice
    node.in_scene = true;
    pending.insert(pending.end(), node.children.begin(), node.children.end());
  }
}

std::vector<bool> used_materials(const Document& document, const Scene& scene) {
  std::vector<bool> used(document.model.materials.size(), false);
  for (size_t i = 0; i < document.model.nodes.size(); ++i) {
    const int mesh = document.model.nodes[i].mesh;
    if (mesh == none || !scene.nodes[i].in_scene) continue;
    for (const tinygltf::Primitive& primitive : document.model.meshes[mesh].primitives) {
      if (primitive.material != none && primitive.mode >= TINYGLTF_MODE_TRIANGLES) used[primitive.material] = true;
    }
  }
  return used;
}

void import_lights(const Document& document, Scene& scene, ImportContext& context) {
  for (size_t i = 0; i < document.model.nodes.size(); ++i) {
    const tinygltf::Node& node = document.model.nodes[i];
    const tinygltf::Value* reference = extension(node.extensions, "KHR_lights_punctual");
    if (!reference || !scene.nodes[i].in_scene) continue;
    const size_t index = static_cast<size_t>(index_or_none(*reference, "light"));
    const tinygltf::Light& source = document.model.lights[index];
    const std::string where = label("light", index, source.name);
    SceneLight light;
    light.name = !source.name.empty() ? source.name : node.name;
    light.node = static_cast<int>(i);
    if (source.type == "directional") {
      light.type = LightType::directional;
    } else if (source.type == "spot") {
      light.type = LightType::spot;
      light.outer_angle = static_cast<float>(std::clamp(source.spot.outerConeAngle, 1e-4, 1.5707963));
      light.inner_angle = static_cast<float>(source.spot.innerConeAngle);
      if (light.outer_angle != static_cast<float>(source.spot.outerConeAngle) || !(light.inner_angle >= 0) ||
          !(light.inner_angle < light.outer_angle)) {
        light.inner_angle = std::clamp(light.inner_angle, 0.f, 0.999f * light.outer_angle);
        context.warn("{}: its cone angles were clamped to 0 <= inner < outer <= pi/2", where);
      }
    } else if (source.type != "point") {
      context.warn("{}: its type '{}' is unknown; it was left out", where, source.type);
      continue;
    }
    glm::vec3 color(1);
    for (size_t c = 0; c < source.color.size() && c < 3; ++c)
      color[static_cast<int>(c)] = static_cast<float>(source.color[c]);
    light.intensity = color * static_cast<float>(source.intensity);
    if (glm::any(glm::lessThan(light.intensity, glm::vec3(0)))) {
      context.warn("{}: its negative intensity was taken as 0", where);
      light.intensity = glm::max(light.intensity, glm::vec3(0));
    }
    if (glm::any(glm::greaterThan(light.intensity, glm::vec3(1e30f))))
      context.fail("{}: its intensity is too large", where);
    scene.lights.push_back(std::move(light));
  }
}

void import_cameras(const Document& document, Scene& scene, ImportContext& context) {
  constexpr double widest = 3.12;  // just below pi, which would see a whole half space
  for (size_t i = 0; i < document.model.nodes.size(); ++i) {
    const tinygltf::Node& node = document.model.nodes[i];
    if (node.camera == none || !scene.nodes[i].in_scene) continue;
    const tinygltf::Camera& source = document.model.cameras[node.camera];
    const std::string where = label("camera", static_cast<size_t>(node.camera), source.name);
    SceneCamera camera;
    camera.name = !source.name.empty() ? source.name : node.name;
    camera.node = static_cast<int>(i);
    camera.perspective = source.type == "perspective";
    if (camera.perspective) {
      if (source.perspective.yfov > widest) context.warn("{}: its field of view was clamped below pi", where);
      camera.yfov = static_cast<float>(std::min(source.perspective.yfov, widest));
      camera.aspect = static_cast<float>(source.perspective.aspectRatio);
    } else {
      camera.xmag = static_cast<float>(std::abs(source.orthographic.xmag));
      camera.ymag = static_cast<float>(std::abs(source.orthographic.ymag));
      if (!(camera.xmag > 0) || !(camera.ymag > 0)) context.fail("{}: xmag and ymag must not be 0", where);
    }
    scene.cameras.push_back(std::move(camera));
  }
}

}  // namespace lucarium::gltf
