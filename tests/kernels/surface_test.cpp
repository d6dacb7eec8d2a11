// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/texture.clh and surface.clh against the host's scene functions and against geometry.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "lucarium/scene/device/texture_sampling.h"
#include "surface_fixture.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Image noise_image(uint32_t width, uint32_t height) {
  std::mt19937 random(width * 31 + height);
  Image image{"noise", width, height, {}};
  for (uint32_t i = 0; i < 4 * width * height; ++i) image.rgba.push_back(static_cast<uint8_t>(random() & 255));
  return image;
}

}  // namespace

TEST_CASE("textures are looked up as on the host, for every wrap mode and filter") {
  Scene scene = attribute_scene();
  scene.images = {noise_image(7, 5), noise_image(1, 1), noise_image(64, 32)};
  for (int image = 0; image < 3; ++image) {
    for (const Wrap u : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
      for (const Wrap v : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        scene.textures.push_back({image, u, v, false, image == 0});
        scene.textures.push_back({image, u, v, true, image == 2});
      }
    }
  }
  const SceneBuffers buffers(*test_device(), scene);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-3, 3);
  std::vector<float2> uvs;
  for (int i = 0; i < 2000; ++i) uvs.emplace_back(uniform(random), uniform(random));
  for (const float x : {0.f, 1.f, -1.f, 0.5f, 2.f}) {
    for (const float y : {0.f, 1.f, -0.5f}) uvs.emplace_back(x, y);
  }
  const size_t ordinary = uvs.size();
  // Nothing to compare with, but no crash and no foreign memory.
  const float wild[] = {1e30f, -1e30f, INFINITY, -INFINITY, std::numeric_limits<float>::quiet_NaN()};
  for (const float x : wild) uvs.emplace_back(x, -x);
  const auto points = test_buffer(uvs);
  const auto values = test_buffer<float4>(uvs.size());
  for (size_t t = 0; t < scene.textures.size(); ++t) {
    CAPTURE(t);
    run_kernel(surface_program(), "lookup_textures", uvs.size(), 64, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("texture", static_cast<uint>(t)).arg("count", static_cast<uint>(uvs.size()));
      pass.arg("uvs", points).arg("values", values);
    });
    const auto got = values.download();
    size_t different = 0;
    for (size_t i = 0; i < ordinary; ++i) {
      const glm::vec4 expected = sample_texture(scene, scene.textures[t], {uvs[i].x, uvs[i].y});
      const glm::vec4 value(got[i].x, got[i].y, got[i].z, got[i].w);
      different += glm::distance(value, expected) > 1e-4f;
    }
    // Nearest: coordinates whose rounding to the image's period crosses a texel's edge.
    CHECK(different <= (scene.textures[t].nearest ? 2u : 0u));
  }
}

TEST_CASE("base colours use factor, transformed texture coordinates of either set, and vertex colours") {
  Scene scene = attribute_scene();
  scene.images = {noise_image(16, 16)};
  scene.textures = {{0, Wrap::repeat, Wrap::repeat, false, true}};
  TextureUse& use = scene.materials[0].base_color_texture;
  use.texture = 0, use.uv_set = 1, use.offset = {0.3f, -0.2f}, use.scale = {0.4f, 0.7f}, use.rotation = 0.6f;
  scene.materials[0].base_color = glm::vec4(0.5f, 0.25f, 1, 0.75f);
  const SceneBuffers buffers(*test_device(), scene);
  const float u = 0.3f, v = 0.5f;
  const SurfaceResult s = make_surfaces(buffers, {hit_at(0, u, v)}, {0, 0, -1})[0];
  const glm::vec2 uv = (1 - u - v) * glm::vec2(1, 2) + u * glm::vec2(3, 4) + v * glm::vec2(5, 6);
  CHECK(s.uvs.z == test::relative(uv.x));
  CHECK(s.uvs.w == test::relative(uv.y));
  CHECK(s.uvs.x == test::relative(0.2 * 0.1 + 0.3 * 0.9 + 0.5 * 0.2));
  const glm::vec4 color(1 - u - v, u, v, (1 - u - v) + 0.5f * u + 0.25f * v);
  CHECK(near(s.color.xyz(), glm::vec3(color)));
  const glm::vec4 expected =
      scene.materials[0].base_color * color * sample_texture(scene, scene.textures[0], texture_transform(use)(uv));
  CHECK(near(s.base.xyz(), glm::vec3(expected), 1e-4f));
  CHECK(s.base.w == test::relative(expected.w, 1e-4));
}

TEST_CASE("normals turn to the side of view, mirrored instances included") {
  const glm::mat4 matrices[] = {glm::mat4(1), glm::mat4(glm::vec4(-2, 0, 0, 0), glm::vec4(0, 1, 0, 0),
                                                        glm::vec4(0, 0, 3, 0), glm::vec4(5, 6, 7, 1))};
  for (const glm::mat4& matrix : matrices) {
    Scene scene = attribute_scene(matrix);
    const SceneBuffers buffers(*test_device(), scene);
    const glm::vec3 front(0, 0, 1);
    const float u = 0.25f, v = 0.25f;
    // A mirrored instance's triangles swap two vertices, so that they stay counter-clockwise.
    const SurfaceResult a = make_surfaces(buffers, {hit_at(0, u, v)}, -front)[0];
    const SurfaceResult b = make_surfaces(buffers, {hit_at(0, u, v)}, front)[0];
    const SurfaceResult g = make_surfaces(buffers, {hit_at(0, u, v)}, front, 2u)[0];
    CHECK(near(a.n_g_flags.xyz(), front));
    CHECK(near(b.n_g_flags.xyz(), -front));
    CHECK((static_cast<int>(a.n_g_flags.w) & 1) == 1);
    CHECK((static_cast<int>(b.n_g_flags.w) & 1) == 0);
    const glm::mat3 normal_matrix = glm::transpose(glm::inverse(glm::mat3(matrix)));
    glm::vec3 normal(0);
    for (int i = 0; i < 3; ++i) {
      normal += (i == 0 ? 0.5f : 0.25f) * glm::normalize(normal_matrix * scene.meshes[0].normals[i]);
    }
    CHECK(near(a.n_s_offset.xyz(), glm::normalize(normal)));
    CHECK(near(b.n_s_offset.xyz(), -glm::normalize(normal)));
    CHECK(near(g.n_s_offset.xyz(), -front));
    const glm::vec3 middle = glm::vec3(matrix * glm::vec4(0.25f, 0.25f, 0, 1));
    CHECK(near(a.position_material.xyz(), middle));
  }
}

TEST_CASE("a stored point has two sides, whichever way its triangle lies, without area too") {
  Scene scene = attribute_scene();
  scene.meshes[0].positions.insert(scene.meshes[0].positions.end(), {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}});  // no area
  for (std::vector<glm::vec2>& uv : scene.meshes[0].uv) uv.insert(uv.end(), 3, glm::vec2(0));
  scene.meshes[0].normals.insert(scene.meshes[0].normals.end(), 3, glm::vec3(1, 0, 0));
  scene.meshes[0].tangents.insert(scene.meshes[0].tangents.end(), 3, glm::vec4(0, 1, 0, 1));
  scene.meshes[0].colors.insert(scene.meshes[0].colors.end(), 3, glm::vec4(1));
  scene.meshes[0].triangles.push_back({3, 4, 5});
  const SceneBuffers buffers(*test_device(), scene);
  const auto points = test_buffer(std::vector<Hit>{hit_at(0, 0.25f, 0.25f), hit_at(1, 0.25f, 0.25f)});
  const auto results = test_buffer<float4>(16);
  run_kernel(surface_program(), "stand_on_points", 2, 1, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("points", points).arg("count", 2u).arg("results", results);
  });
  const auto got = results.download();
  const SurfaceResult seen = make_surfaces(buffers, {hit_at(0, 0.25f, 0.25f)}, {0, 0, -1})[0];
  for (size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    const bool front = i % 2 == 0;
    const float4* surface = &got[4 * i];
    CHECK((static_cast<uint>(surface[0].w) & 1u) == (front ? 1u : 0u));
    CHECK(near(surface[1].xyz(), (front ? 1.f : -1.f) * got[8 * (i / 2) + 1].xyz()));
    CHECK(glm::length(surface[1].xyz()) == test::relative(1, 1e-5));
    CHECK(near(surface[3].xyz(), surface[1].xyz()));
    CHECK(surface[3].w == 1.f);
    if (i < 2) {
      CHECK(near(surface[0].xyz(), seen.position_material.xyz()));
      CHECK(near(surface[1].xyz(), {0, 0, front ? 1 : -1}));
      CHECK(near(surface[2].xyz(), (front ? 1.f : -1.f) * seen.n_s_offset.xyz()));
    }
  }
}

TEST_CASE("normal maps tilt towards tangent and bitangent by their scale") {
  // Texel (191, 223, 255): x = .498, y = .749, z = 1. The mirrored instance mirrors what is seen.
  for (const float mirror : {1.f, -1.f}) {
    glm::mat4 matrix(1);
    matrix[0][0] = mirror;
    Scene scene = attribute_scene(matrix);
    scene.meshes[0].normals.assign(3, glm::vec3(0, 0, 1));
    scene.images.push_back({"normal", 1, 1, {191, 223, 255, 255}});
    scene.textures = {{0, Wrap::repeat, Wrap::repeat, false, false}};
    scene.materials[0].normal_texture.texture = 0;
    scene.materials[0].normal_texture.strength = 0.5f;
    const SceneBuffers buffers(*test_device(), scene);
    const float x = 0.5f * (191 / 255.f * 2 - 1), y = 0.5f * (223 / 255.f * 2 - 1);
    const glm::vec3 expected = glm::normalize(glm::vec3(mirror * x, y, 1));
    CHECK(near(make_surfaces(buffers, {hit_at(0, 0.3f, 0.3f)}, {0, 0, -1})[0].n_s_offset.xyz(), expected));
    CHECK(near(make_surfaces(buffers, {hit_at(0, 0.3f, 0.3f)}, {0, 0, 1})[0].n_s_offset.xyz(), -expected));
  }
}

namespace {

/// For `count` seeds, whether a ray stops at a point of a triangle.
std::vector<uint> stopped(const SceneBuffers& buffers, uint triangle, float u, float v, uint first_seed, uint count) {
  const auto result = test_buffer<uint>(count);
  run_kernel(surface_program(), "count_passes", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("triangle", triangle)
        .arg("u", u)
        .arg("v", v)
        .arg("first_seed", first_seed)
        .arg("count", count)
        .arg("passes", result);
  });
  return result.download();
}
uint passes(const SceneBuffers& buffers, float u, float v, uint first_seed, uint count) {
  const std::vector<uint> all = stopped(buffers, 0, u, v, first_seed, count);
  return std::accumulate(all.begin(), all.end(), 0u);
}

}  // namespace

TEST_CASE("MASK cuts at the cutoff, BLEND lets its share of the seeds through") {
  Scene scene = attribute_scene();
  scene.materials[0].base_color.a = 0.8f;
  const uint n = 1 << 16;
  // Alpha is .8 at the first vertex, .4 at the second, .2 at the third.
  const double alpha = 0.8 * (0.5 * 1 + 0.25 * 0.5 + 0.25 * 0.25);
  {
    const SceneBuffers buffers(*test_device(), scene);
    CHECK(passes(buffers, 1, 0, 1, 64) == 64);  // opaque: alpha means nothing
  }
  scene.materials[0].alpha_mode = AlphaMode::mask;
  scene.materials[0].alpha_cutoff = 0.39f;
  {
    const SceneBuffers buffers(*test_device(), scene);
    CHECK(passes(buffers, 0.99f, 0, 1, 64) == 64);
    CHECK(passes(buffers, 0, 0.99f, 1, 64) == 0);
  }
  // Alpha exactly at the cutoff is there (glTF 2.0, 3.9.4); alpha is the factor's at the first vertex.
  scene.materials[0].alpha_cutoff = 0.8f;
  CHECK(passes(SceneBuffers(*test_device(), scene), 0, 0, 1, 64) == 64);
  scene.materials[0].alpha_mode = AlphaMode::blend;
  const SceneBuffers buffers(*test_device(), scene);
  const double share = passes(buffers, 0.25f, 0.25f, 1, n) / double(n);
  CHECK(std::abs(share - alpha) < 5 * std::sqrt(alpha * (1 - alpha) / n));
  CHECK(passes(buffers, 0.25f, 0.25f, LUCARIUM_SEED_OPAQUE, 1) == 1);
  scene.materials[0].base_color.a = 1e-6f;
  CHECK(passes(SceneBuffers(*test_device(), scene), 0.25f, 0.25f, LUCARIUM_SEED_OPAQUE, 1) == 1);
}

TEST_CASE("alpha comes from the texture at the coordinates that it names, and every veil decides by itself") {
  // Two copies of a triangle whose texture is a hole on its right half. By the second coordinates, scaled, the first
  // two corners are in the left half and the third in the right one; by the first coordinates all are in the left.
  Scene scene = attribute_scene();
  scene.meshes[0].colors.clear();
  scene.instances.push_back(scene.instances[0]);
  scene.images.push_back({"half", 2, 1, {255, 255, 255, 102, 255, 255, 255, 0}});
  scene.textures = {{0, Wrap::repeat, Wrap::repeat, true, false}};
  TextureUse& use = scene.materials[0].base_color_texture;
  use.texture = 0, use.uv_set = 1, use.scale = glm::vec2(0.125f);
  scene.materials[0].alpha_mode = AlphaMode::mask;
  scene.materials[0].alpha_cutoff = 0.3f;
  {
    const SceneBuffers buffers(*test_device(), scene);
    CHECK(passes(buffers, 0, 0, 1, 64) == 64);
    CHECK(passes(buffers, 1, 0, 1, 64) == 64);
    CHECK(passes(buffers, 0, 1, 1, 64) == 0);
  }
  scene.materials[0].alpha_mode = AlphaMode::blend;
  const SceneBuffers buffers(*test_device(), scene);
  const uint n = 1 << 14;
  const std::vector<uint> first = stopped(buffers, 0, 0, 0, 1, n), second = stopped(buffers, 1, 0, 0, 1, n);
  double one = 0, both = 0;
  for (uint i = 0; i < n; ++i) one += second[i], both += first[i] & second[i];
  CHECK(std::abs(one / n - 0.4) < 5 * std::sqrt(0.24 / n));
  CHECK(std::abs(both / n - 0.16) < 5 * std::sqrt(0.16 * 0.84 / n));
}
