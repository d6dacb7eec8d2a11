// SPDX-License-Identifier: Apache-2.0
// Specular chains against closed forms: between mirrors, through tinted glass, to punctual lights.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/specular_chains/specular_chains.h"
#include "made_scene.h"
#include "test_support.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kScatterings = 8;  // SCATTERINGS of chains.cl

class ChainRig {
 public:
  explicit ChainRig(const Scene& scene, uint32_t targets)
      : targets_(targets),
        scheduler_(test_device()),
        buffers_(*test_device(), scene),
        bvh_(*test_device(), scene, buffers_),
        program_(make_program()),
        gain_(*test_device(), "test", "gain", size_t{targets} * kScatterings) {}

  /// Mean light by number of scatterings, of chains that start at `origin` along `direction`.
  std::array<glm::dvec3, kScatterings> light(const glm::vec3& origin, const glm::vec3& direction,
                                             const ChainSettings& settings, bool glowing, bool punctual) {
    const auto bind = [&](PassBuilder& pass) { pass.arg("glowing", glowing ? 1u : 0u).arg("gain", gain_); };
    SpecularChains chains(*test_device(), scheduler_, buffers_, bvh_, {targets_, punctual, "test", "targets"},
                          {program_, "advance_test_chains", "add_test_light", bind, bind});
    ScheduleRecorder recorder = scheduler_.record("begin", "test");
    recorder.pass("begin", program_, "begin_test_chains")
        .global(targets_)
        .arg("count", targets_)
        .arg("origin", float4(origin, 0))
        .arg("direction", float4(direction, 0))
        .arg("chains", chains.chains())
        .arg("rays", chains.first_rays())
        .arg("queue", chains.queue())
        .arg("active", chains.active())
        .arg("gain", gain_);
    Schedule begin = recorder.compile();
    scheduler_.run(begin);
    REQUIRE(chains.follow(settings));
    scheduler_.finish();
    CHECK(chains.rays() >= targets_);
    rays = chains.rays();
    std::array<glm::dvec3, kScatterings> mean{};
    const std::vector<float4> gain = gain_.download();
    for (size_t i = 0; i < gain.size(); ++i) mean[i % kScatterings] += glm::dvec3(gain[i].xyz()) / double(targets_);
    return mean;
  }

  glm::dvec3 reflected(float u, float v, const glm::vec3& direction, const glm::vec3& light, float intensity) {
    const auto result = test_buffer<float4>(1);
    run_kernel(program_, "reflected_light", 1, 1, [&](PassBuilder& pass) {
      buffers_.bind(pass);
      pass.arg("u", u).arg("v", v).arg("direction", float4(direction, 0)).arg("light", float4(light, 0));
      pass.arg("intensity", float4(intensity, intensity, intensity, 0)).arg("result", result);
    });
    return glm::dvec3(result.download()[0].xyz());
  }

  uint64_t rays = 0;

 private:
  static Program make_program() {
    SourceLibrary library;
    library.add(test_services_kernels());
    return Program(*test_device(), library, {"test/chains", {"test_services/specular_chains/chains.cl"}, {}});
  }
  uint32_t targets_;
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  Bvh bvh_;
  Program program_;
  TypedBuffer<float4> gain_;
};

ChainSettings settings(uint32_t limit = LUCARIUM_NONE) {
  ChainSettings result{};
  result.seed = 7;
  result.lit = 1;
  result.first_light = 1;
  result.limit = limit;
  result.max_vertices = SpecularChains::kMaxVertices;
  return result;
}

/// A square of 2 m at height z that shows its front to +z or -z.
void add_square(Scene& scene, float z, bool upwards, int material) {
  const Mesh mesh = MeshBuilder("square").box_face({-1, -1, z}, {1, 1, z + 1}, 2, 0, upwards).take();
  add_instance(scene, add_mesh(scene, mesh), material);
}

}  // namespace

TEST_CASE("between two mirrors of reflectance 1/2, k scatterings bring 2^(1-k), and none beyond the limit") {
  Scene scene;
  const int mirror = add_metal(scene, "mirror", glm::vec3(0.5f), 0);
  add_square(scene, 0, true, mirror);
  add_square(scene, 1, false, mirror);
  const uint32_t targets = 4096;
  ChainRig rig(scene, targets);
  const auto all = rig.light({0.1f, 0.2f, 0.5f}, {0, 0, 1}, settings(), true, false);
  for (uint32_t k = 1; k < kScatterings; ++k) {
    // Roulette from the third extension on: a chain goes on with probability 1/2 and keeps its throughput of 1/4.
    const double expected = k < kScatterings - 1 ? std::pow(0.5, k - 1) : 2 * std::pow(0.5, k - 1);
    const double deviation = k <= 3 ? 0 : std::sqrt(expected * 0.25 / targets) * (k < kScatterings - 1 ? 1 : 2);
    CAPTURE(k);
    CHECK(all[k].x == test::within(expected, 5 * deviation + 1e-6));
  }
  const auto limited = rig.light({0.1f, 0.2f, 0.5f}, {0, 0, 1}, settings(3), true, false);
  for (uint32_t k = 1; k < kScatterings; ++k) CHECK(limited[k].x == test::within(k <= 3 ? all[k].x : 0, 1e-5));
}

TEST_CASE("light through a tinted block is dimmed by two surfaces and the way between them") {
  Scene scene;
  SceneMaterial lamp;
  lamp.base_color = glm::vec4(0, 0, 0, 1);
  lamp.metallic = 0, lamp.ior = 1;  // reflects nothing
  lamp.emissive_factor = glm::vec3(1);
  add_square(scene, 2, false, add_material(scene, lamp));
  SceneMaterial glass;
  glass.metallic = 0, glass.roughness = 0, glass.transmission = 1, glass.thickness = 1;
  glass.attenuation_distance = 0.5f;
  glass.attenuation_color = glm::vec3(0.5f, 0.25f, 1);
  add_instance(scene, add_mesh(scene, MeshBuilder("block").box({-1, -1, 0.5f}, {1, 1, 1}).take()),
               add_material(scene, glass));
  const uint32_t targets = 1 << 15;
  ChainRig rig(scene, targets);
  const auto by_count = rig.light({0.1f, 0.2f, 0}, {0, 0, 1}, settings(), false, false);
  glm::dvec3 light(0);
  for (const glm::dvec3& l : by_count) light += l;
  const double f = 0.04;  // Fresnel reflectance along the normal at an index of 1.5
  for (int c = 0; c < 3; ++c) {
    const double tau = std::array{0.5, 0.25, 1.0}[c];
    const double expected = (1 - f) * (1 - f) * tau / (1 - f * f * tau * tau);
    CAPTURE(c);
    // A chain is transmitted or not: at most 8 % of them are not.
    CHECK(light[c] == test::within(expected, 5 * tau * std::sqrt(0.08 / targets)));
  }
  ChainSettings unlit = settings();
  unlit.lit = 0;
  for (const glm::dvec3& l : rig.light({0.1f, 0.2f, 0}, {0, 0, 1}, unlit, false, false)) CHECK(l.x == 0);
  // Emitters count from the fourth vertex on: only light that was reflected within the block.
  ChainSettings later = settings();
  later.first_light = 4;
  glm::dvec3 rest(0);
  for (const glm::dvec3& l : rig.light({0.1f, 0.2f, 0}, {0, 0, 1}, later, false, false)) rest += l;
  CHECK(rest.z == test::within((1 - f) * (1 - f) * f * f, 5 * std::sqrt(f * f / targets)));
}

TEST_CASE("a chain that meets a rough metal receives a point light's reflection there, unless something is between") {
  for (const bool blocked : {false, true}) {
    CAPTURE(blocked);
    Scene scene;
    add_square(scene, 0, true, add_metal(scene, "rough", glm::vec3(0.8f), 0.6f));
    const glm::vec3 light(0.4f, 0.1f, 0.9f);
    add_light(scene, LightType::point, 3, light, light - glm::vec3(0, 0, 1));
    if (blocked)
      add_instance(scene, add_mesh(scene, MeshBuilder("plate").box({0.2f, 0, 0.4f}, {0.4f, 0.2f, 0.42f}).take()), 0);
    ChainRig rig(scene, 16);  // all alike
    const glm::vec3 way = glm::normalize(glm::vec3(0.3f, 0, -1)), point(0.25f, 0.1f, 0);
    const auto by_count = rig.light(point - way, way, settings(1), false, true);
    CHECK(by_count[2].x == 0);  // limit 1: the scattering at the start is all there is
    const auto two = rig.light(point - way, way, settings(2), false, true);
    if (blocked) {
      CHECK(two[2].x == 0);
      continue;
    }
    const std::vector<Vertex> v = SceneBuffers(*test_device(), scene).scene_vertices.download();
    const std::vector<Triangle> t = SceneBuffers(*test_device(), scene).scene_triangles.download(0, 1);
    const glm::vec3 a(v[t[0].v0].position.xyz()), e1 = v[t[0].v1].position.xyz() - a,
                                                  e2 = v[t[0].v2].position.xyz() - a;
    const glm::mat2 edges{glm::vec2(e1), glm::vec2(e2)};
    const glm::vec2 b = glm::inverse(edges) * glm::vec2(point - a);  // of triangle 0, if outside of it too: it is plane
    const glm::dvec3 expected = rig.reflected(b.x, b.y, way, light, 3);
    CHECK(expected.x > 0.1);
    CHECK(two[2].x == test::relative(expected.x, 1e-3));
  }
}

TEST_CASE("a point light within a tinted block: chains into the block find what it leaves of both ways") {
  // A rough metal at the bottom of 1 m of coloured air, a light in it; outside of it nothing is absorbed.
  Scene scene;
  add_square(scene, 0, true, add_metal(scene, "rough", glm::vec3(0.8f), 0.6f));
  SceneMaterial air;
  air.metallic = 0, air.roughness = 0, air.transmission = 1, air.thickness = 1, air.ior = 1;
  air.attenuation_distance = 1;
  air.attenuation_color = glm::vec3(0.25f, 0.5f, 1);
  add_instance(scene, add_mesh(scene, MeshBuilder("block").box({-2, -2, -0.1f}, {2, 2, 1}).take()),
               add_material(scene, air));
  const glm::vec3 light(0.4f, 0.1f, 0.9f), point(0.25f, 0.1f, 0), way = glm::normalize(glm::vec3(0.3f, 0, -1));
  add_light(scene, LightType::point, 3, light, light - glm::vec3(0, 0, 1));
  ChainRig rig(scene, 16);  // all alike
  const auto found = rig.light(point - 2.f * way, way, settings(), false, true);
  const std::vector<Vertex> v = SceneBuffers(*test_device(), scene).scene_vertices.download();
  const std::vector<Triangle> t = SceneBuffers(*test_device(), scene).scene_triangles.download(0, 1);
  const glm::vec3 a(v[t[0].v0].position.xyz()), e1 = v[t[0].v1].position.xyz() - a, e2 = v[t[0].v2].position.xyz() - a;
  const glm::vec2 b = glm::inverse(glm::mat2{glm::vec2(e1), glm::vec2(e2)}) * glm::vec2(point - a);
  const double length = double{1 / -way.z} + double{glm::distance(light, point)};
  for (int c = 0; c < 3; ++c) {
    CAPTURE(c);
    const double expected = rig.reflected(b.x, b.y, way, light, 3)[c] * std::pow(std::array{0.25, 0.5, 1.0}[c], length);
    CHECK(found[3][c] == test::relative(expected, 1e-3));
  }
}
