// SPDX-License-Identifier: Apache-2.0
// The hierarchy over a scene's buffers: transformed instances, changes, and materials with holes.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/device/scene_buffers.h"
#include "tracer.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Mesh unit_square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.uv[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

void place(Scene& scene, int material, const glm::mat4& matrix) {
  Node node;
  node.matrix = matrix;
  scene.nodes.push_back(node);
  SceneInstance instance;
  instance.node = static_cast<int>(scene.nodes.size()) - 1;
  instance.mesh = 0;
  instance.material = material;
  scene.instances.push_back(instance);
}

glm::mat4 at_depth(float z) { return glm::translate(glm::mat4(1.f), glm::vec3(0, 0, z)); }

/// Squares over [0,1]² at z = 1 (with the given material) and, opaque, at z = 0.
Scene two_squares(const SceneMaterial& front) {
  Scene scene;
  scene.source = "test";
  scene.meshes = {unit_square()};
  scene.materials.resize(2);
  scene.materials[1] = front;
  place(scene, 1, at_depth(1));
  place(scene, 0, at_depth(0));
  evaluate(scene, 0);
  return scene;
}

/// Rays down from z = 2 on a grid that avoids the squares' diagonal, with seeds 1, 2, …
std::vector<Ray> rays_down(uint32_t side, float length = INFINITY) {
  std::vector<Ray> rays;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const auto n = static_cast<float>(side);
      Ray ray =
          make_ray({(static_cast<float>(x) + 0.4f) / n, (static_cast<float>(y) + 0.6f) / n, 2}, {0, 0, -1}, length);
      ray.origin.w = std::bit_cast<float>(y * side + x + 1);
      rays.push_back(ray);
    }
  return rays;
}

}  // namespace

TEST_CASE("cut-out texels let rays through") {
  Tracer tracer;
  SceneMaterial front;
  front.alpha_mode = AlphaMode::mask;
  front.base_color_texture.texture = 0;
  Scene scene = two_squares(front);
  Image image;
  image.width = 2, image.height = 2;
  image.rgba = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 255};
  scene.images = {image};
  SceneTexture texture;
  texture.image = 0, texture.nearest = true;
  scene.textures = {texture};
  const SceneBuffers buffers(tracer.device(), scene);
  REQUIRE((buffers.info().flags & LUCARIUM_SCENE_HAS_ALPHA) != 0);
  for (const BvhTraversal traversal : traversals) {
    const Bvh bvh(tracer.device(), scene, buffers, traversal);
    const std::vector<Ray> rays = rays_down(20), short_rays = rays_down(20, 1.5f);
    const Results results = tracer.trace(bvh, rays), in_front = tracer.trace(bvh, short_rays);
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool opaque = (rays[i].origin.x < 0.5f) == (rays[i].origin.y < 0.5f);
      const Hit& hit = results.hits[i];
      wrong += (hit.triangle < 2) != opaque || hit.triangle > 3 || hit.distance != (opaque ? 1.f : 2.f);
      wrong += results.occluded[i] != 1 || in_front.occluded[i] != opaque;
      wrong += (in_front.hits[i].triangle == LUCARIUM_NO_HIT) == opaque;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("blended surfaces stop rays with probability alpha, the same ones for closest and any hit") {
  Tracer tracer;
  SceneMaterial front;
  front.alpha_mode = AlphaMode::blend;
  front.base_color.a = 0.25f;
  const Scene scene = two_squares(front);
  const SceneBuffers buffers(tracer.device(), scene);
  std::vector<uint32_t> first;
  for (const BvhTraversal traversal : traversals) {
    const Bvh bvh(tracer.device(), scene, buffers, traversal);
    const Results results = tracer.trace(bvh, rays_down(200)), in_front = tracer.trace(bvh, rays_down(200, 1.5f));
    std::vector<uint32_t> stopped;
    for (const Hit& hit : results.hits) stopped.push_back(hit.triangle < 2);
    CHECK(in_front.occluded == stopped);
    const auto count = static_cast<double>(std::count(stopped.begin(), stopped.end(), 1u));
    // Binomial with p = 1/4, n = 40000: 5 standard deviations.
    CHECK(std::abs(count - 10000) < 5 * std::sqrt(40000 * 0.25 * 0.75));
    std::vector<Ray> opaque = rays_down(20);
    for (Ray& ray : opaque) ray.origin.w = std::bit_cast<float>(uint32_t{LUCARIUM_SEED_OPAQUE});
    for (const Hit& hit : tracer.trace(bvh, opaque).hits) CHECK(hit.triangle < 2);
    if (first.empty()) first = stopped;
    CHECK(stopped == first);
  }
}

TEST_CASE("a material that becomes transparent needs new passes, and says so") {
  Tracer tracer;
  Scene scene = two_squares(SceneMaterial{});
  SceneBuffers buffers(tracer.device(), scene);
  Bvh bvh(tracer.device(), scene, buffers);
  const uint64_t generation = bvh.generation();
  CHECK(tracer.trace(bvh, rays_down(1)).hits[0].distance == 1);
  scene.materials[1].alpha_mode = AlphaMode::blend;
  scene.materials[1].base_color.a = 0;
  SceneChange change;
  change.materials = {1};
  buffers.update(scene, change);
  bvh.update(scene, buffers, change);
  CHECK(bvh.generation() > generation);
  CHECK(tracer.trace(bvh, rays_down(1)).hits[0].distance == 2);
}

TEST_CASE("every triangle knows whether its material lets rays through, also after a change of materials") {
  Tracer tracer;
  SceneMaterial veil;
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color.a = 0;
  Scene scene = two_squares(veil);
  const auto depth_of = [](int i) { return 1 - 0.01f * static_cast<float>(i); };
  for (int i = 2; i < 60; ++i) place(scene, i < 40 ? 1 : 0, at_depth(depth_of(i)));
  scene.instances[1].material = 1;
  evaluate(scene, 0);
  SceneBuffers buffers(tracer.device(), scene);
  for (const BvhTraversal traversal : traversals) {
    Bvh bvh(tracer.device(), scene, buffers, traversal);
    for (const Hit& hit : tracer.trace(bvh, rays_down(4)).hits) CHECK(hit.triangle / 2 == 40);
    const uint64_t generation = bvh.generation();
    const auto change_to = [&](AlphaMode mode) {
      scene.materials[0] = veil;
      scene.materials[0].alpha_mode = mode;
      SceneChange change;
      change.materials = {0};
      buffers.update(scene, change);
      bvh.update(scene, buffers, change);
    };
    change_to(AlphaMode::blend);
    for (const Hit& hit : tracer.trace(bvh, rays_down(4)).hits) CHECK(hit.triangle == LUCARIUM_NO_HIT);
    change_to(AlphaMode::opaque);
    for (const Hit& hit : tracer.trace(bvh, rays_down(4)).hits) CHECK(hit.triangle / 2 == 40);
    CHECK(bvh.generation() == generation);  // recorded passes stay valid
  }
}

TEST_CASE("moved instances are followed") {
  Tracer tracer;
  Scene scene = two_squares(SceneMaterial{});
  SceneBuffers buffers(tracer.device(), scene);
  Bvh bvh(tracer.device(), scene, buffers);
  CHECK(tracer.trace(bvh, rays_down(3)).hits[4].distance == 1);
  scene.nodes[0].matrix = glm::scale(at_depth(1.5f), glm::vec3(1, 1, -1));
  const SceneChange change = evaluate(scene, 1);
  REQUIRE(change.moved_instances == std::vector<int>{0});
  buffers.update(scene, change);
  bvh.update(scene, buffers, change);
  for (const Hit& hit : tracer.trace(bvh, rays_down(3)).hits) {
    CHECK(hit.distance == 0.5f);
    CHECK(hit.triangle < 2);
  }
}

TEST_CASE("a scene without triangles") {
  Tracer tracer;
  Scene scene;
  scene.materials.resize(1);
  evaluate(scene, 0);
  const SceneBuffers buffers(tracer.device(), scene);
  const Bvh bvh(tracer.device(), scene, buffers);
  CHECK(Bvh::estimate_bytes(scene) > 0);
  CHECK(bvh.statistics().triangles == 0);
  CHECK(tracer.trace(bvh, rays_down(2)).occluded == std::vector<uint32_t>(4, 0));
}
