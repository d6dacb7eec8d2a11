// SPDX-License-Identifier: Apache-2.0
#include "ray_subject.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "lucarium/scene/load/load_scene.h"
#include "traced_batch.h"

namespace lucarium::bench {

namespace {

std::vector<Ray> make_primary(const SceneCamera& camera, uint32_t width, uint32_t height) {
  const float half_height = std::tan(0.5f * camera.yfov);
  const float half_width = half_height * static_cast<float>(width) / static_cast<float>(height);
  const glm::mat3 turn(camera.world_from_camera);
  std::vector<Ray> rays;
  for (uint32_t pixel = 0; pixel < width * height; ++pixel) {
    const float x = 2 * (static_cast<float>(pixel % width) + 0.5f) / static_cast<float>(width) - 1;
    const float y = 1 - 2 * (static_cast<float>(pixel / width) + 0.5f) / static_cast<float>(height);
    Ray ray;
    ray.origin = float4(glm::vec3(camera.world_from_camera[3]), 0.f);
    ray.direction = float4(glm::normalize(turn * glm::vec3(x * half_width, y * half_height, -1)), INFINITY);
    rays.push_back(ray);
  }
  return rays;
}

void make_secondary(RaySubject& subject, const std::vector<Hit>& hits, const Bounds& bounds) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].triangle == LUCARIUM_NO_HIT) continue;
    const Ray& primary = subject.primary[i];
    const Triangle& t = subject.triangles[hits[i].triangle];
    const auto corner = [&](uint32_t vertex) { return glm::vec3(subject.vertices[vertex].position.xyz()); };
    glm::vec3 normal = glm::normalize(glm::cross(corner(t.v1) - corner(t.v0), corner(t.v2) - corner(t.v0)));
    const bool back = glm::dot(normal, primary.direction.xyz()) > 0;
    if (back) normal = -normal;
    subject.starts.push_back({hits[i].triangle | (back ? LUCARIUM_RAY_END_BACK : 0), LUCARIUM_NONE});
    const glm::vec3 origin = primary.origin.xyz() + hits[i].distance * primary.direction.xyz() + 1e-3f * normal;
    const float z = 1 - 2 * uniform(engine), angle = 6.2831853f * uniform(engine), r = std::sqrt(1 - z * z);
    const glm::vec3 on_sphere(r * std::cos(angle), r * std::sin(angle), z);
    Ray ray;
    ray.origin = float4(origin, 0.f);
    ray.direction = float4(glm::normalize(1.0001f * normal + on_sphere), INFINITY);
    subject.diffuse.push_back(ray);
    const glm::vec3 place(uniform(engine), uniform(engine), uniform(engine));
    const glm::vec3 way = bounds.min + (bounds.max - bounds.min) * place - origin;
    ray.direction = float4(glm::normalize(way), glm::length(way));
    subject.shadow.push_back(ray);
  }
}

Scene load_with_camera(const std::string& name) {
  const size_t at = name.rfind('@');
  SceneOverrides overrides;
  if (at != std::string::npos) overrides.camera = name.substr(at + 1);
  return load_scene(name.substr(0, at), overrides);
}

}  // namespace

const char* to_string(RayKind kind) {
  return kind == RayKind::primary ? "primary" : kind == RayKind::diffuse ? "diffuse" : "shadow";
}

RaySubject::RaySubject(Device& device, KernelScheduler& scheduler, const std::string& name, uint32_t width,
                       uint32_t height, bool shuffled)
    : RaySubject(device, scheduler, load_with_camera(name), width, height, shuffled) {}

RaySubject::RaySubject(Device& device, KernelScheduler& scheduler, const Scene& scene, uint32_t width, uint32_t height,
                       bool shuffled) {
  const SceneBuffers buffers(device, scene);
  vertices = buffers.scene_vertices.download();
  triangles = buffers.scene_triangles.download(0, buffers.info().triangle_count);
  primary = make_primary(scene.cameras.at(0), width, height);
  const Bvh bvh(device, vertices, triangles);
  TracedBatch first(device, scheduler, bvh, primary, false);
  first.run();
  make_secondary(*this, first.hits(), scene.bounds());
  if (shuffled) {
    std::mt19937 engine(2);
    std::shuffle(diffuse.begin(), diffuse.end(), engine);
    std::shuffle(shadow.begin(), shadow.end(), engine);
  }
}

const std::vector<Ray>& RaySubject::rays(RayKind kind) const {
  return kind == RayKind::primary ? primary : kind == RayKind::diffuse ? diffuse : shadow;
}

}  // namespace lucarium::bench
