// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/bsdf.clh: albedos against tabulated quadratures, reciprocity, conservation of energy, ideal lobes,
// sides.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "albedo_values.h"
#include "bsdf_scene.h"
#include "closed_forms.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint replicates = 16;

/// Mean of the green weights (sample i belongs to replicate i mod 16).
Estimate estimate(const std::vector<float4>& weights) {
  return interleaved_estimate(weights.size(), [&](size_t i) { return weights[i].y; });
}

uint sample_count() { return full_run() ? 1u << 20 : 1u << 17; }

/// Names a row.
std::string at(float roughness, double cosine) {
  return "r = " + std::to_string(roughness) + ", cos = " + std::to_string(cosine);
}

}  // namespace

TEST_CASE("the albedo table holds the quadratures") {
  const BsdfProbe probe({{"any", metal(1, 1)}});
  const uint n = 1001;
  const auto read = [&](double mu) {
    const auto values = test_buffer<float4>(n);
    run_kernel(kernel_program("bsdf"), "read_albedo_table", n, 64, [&](PassBuilder& pass) {
      pass.arg("scene_albedo_table", probe.buffers().scene_albedo_table).arg("count", n);
      pass.arg("mu", static_cast<float>(mu)).arg("values", values);
    });
    return values.download();
  };
  for (int k = 0; k < 6; ++k) {
    const auto values = read(albedo_cosines[k]);
    // Directional entries are interpolated; the averages almost exact.
    for (const AlbedoRow& row : e1_rows)
      CHECK(std::abs(values[std::lround(row.roughness * 1000)].x - row.values[k]) < 5e-3);
    for (const AlbedoRow& row : b_rows)
      CHECK(std::abs(values[std::lround(row.roughness * 1000)].y - row.values[k]) < 5e-3);
    for (const AverageAlbedo& a : average_albedos) {
      const float4 v = values[std::lround(a.roughness * 1000)];
      CHECK(std::abs(v.z - a.e1) < 2e-5);
      CHECK(std::abs(v.w - a.b) < 1e-4);
      CHECK(std::abs(0.04 * (double(v.z) - v.w) + v.w - a.dielectric) < 1e-4);
    }
  }
  // Exact: a smooth surface, and E1 at normal incidence on the roughest.
  const auto normal = read(1);
  CHECK(normal[0].z == test::relative(1));
  CHECK(normal[0].w == test::relative(1.0 / 21, 1e-6));
  CHECK(normal[1000].x == test::relative(1 - std::log(2.0), 2e-6));
  CHECK(specular_albedo_table().size() == 2 * (129 + 32 * 32));
}

TEST_CASE("the sampled albedo of a white metal is E1") {
  std::vector<NamedMaterial> list;
  for (const AlbedoRow& row : e1_rows) list.push_back({"", metal(1, row.roughness)});
  const BsdfProbe probe(list);
  ClosedForms table;
  for (uint m = 0; m < 6; ++m)
    for (int k = 0; k < 6; ++k) {
      const auto samples = probe.sample(m, direction_at(albedo_cosines[k], 0.15), sample_count(), 7, replicates);
      table.add(at(e1_rows[m].roughness, albedo_cosines[k]), estimate(samples.weights), e1_rows[m].values[k]);
    }
  table.check();
}

TEST_CASE("the sampled albedo of a dielectric is c (1 - Ebar) + F0 (E1 - B) + B") {
  std::vector<NamedMaterial> list;
  for (const AlbedoRow& row : b_rows) list.push_back({"", dielectric(0.5f, row.roughness)});
  const BsdfProbe probe(list);
  ClosedForms table;
  for (uint m = 0; m < 3; ++m)
    for (int k = 0; k < 6; ++k) {
      const float roughness = b_rows[m].roughness;
      const auto samples = probe.sample(m, direction_at(albedo_cosines[k], 0.4), 8 * sample_count(), 3, replicates);
      table.add(at(roughness, albedo_cosines[k]), estimate(samples.weights), dielectric_albedo(0.5, roughness, k));
    }
  table.check();
}

TEST_CASE("the sampled albedos of white, black and plastic surfaces, averaged over the cosine, are the table's") {
  std::vector<NamedMaterial> list;
  for (const AverageAlbedo& a : average_albedos) {
    list.push_back({"E1", metal(1, a.roughness)});
    list.push_back({"B", metal(0, a.roughness)});
    list.push_back({"plastic", dielectric(0, a.roughness)});
  }
  const BsdfProbe probe(list);
  const uint n = 4 * sample_count();
  ClosedForms table;
  for (uint m = 0; m < list.size(); ++m) {
    const AverageAlbedo& a = average_albedos[m / 3];
    const double exact[] = {a.e1, a.b, a.dielectric};
    // B, and with it the dielectric, was quadrature to 1e-4 from r = 0.3 up and to 5e-4 below, rounded to four digits.
    const double slack = m % 3 == 0 ? albedo_rounding : a.roughness < 0.3f ? 5e-4 : 1.5e-4;
    const auto weights = test_buffer<float4>(n);
    probe.run("sample_cosine_views", n, 64, [&](PassBuilder& pass) {
      pass.arg("triangle", m).arg("back", 0u).arg("seed", 13u).arg("replicates", replicates).arg("count", n);
      pass.arg("weights", weights);
    });
    table.add(list[m].name + ", r = " + std::to_string(a.roughness), estimate(weights.download()), exact[m % 3], slack);
  }
  table.check();
}

TEST_CASE("the separable test build gives the albedos of other renderers") {
  const BsdfProbe probe({{"", metal(1, 0.5f)}, {"", metal(1, 1)}}, {{"LUCARIUM_GGX_SEPARABLE", ""}});
  const double exact[2][3] = {{.91581, .87061, .83146}, {.30685, .38357, .51142}};
  const double mu[] = {1, .6, .2};
  ClosedForms table;
  for (uint m = 0; m < 2; ++m)
    for (int k = 0; k < 3; ++k) {
      const auto samples = probe.sample(m, direction_at(mu[k], 0.1), sample_count(), 5, replicates);
      table.add(at(m == 0 ? 0.5f : 1.f, mu[k]), estimate(samples.weights), exact[m][k]);
    }
  table.check();
}

TEST_CASE("the Phong test build has the albedo of its lobe") {
  // At normal incidence the integral of k (n + 2) / 2 pi cos^n cos over the hemisphere is k.
  const BsdfProbe probe({{"", metal(0.8f, std::pow(2.f / 7.f, 0.25f))}}, {{"LUCARIUM_PHONG", ""}});
  ClosedForms table;
  table.add("k", estimate(probe.sample(0, glm::vec3(0, 0, 1), sample_count(), 5, replicates).weights), 0.8);
  table.check();
  const float4 value = probe.evaluate(0, glm::vec3(0, 0, 1), direction_at(0.5, 0.3));
  CHECK(value.y == test::relative(0.8 * 7 / (2 * 3.14159265) * std::pow(0.5, 5) * 0.5, 1e-4));
}

TEST_CASE("cosine-averaged albedos never exceed 1, and are 1 for a white dielectric") {
  const std::vector<NamedMaterial> list = {{"white Lambert", dielectric(1, 0.5f, 1)},
                                           {"white dielectric .1", dielectric(1, 0.1f)},
                                           {"white dielectric .5", dielectric(1, 0.5f)},
                                           {"polished", dielectric(1, 0)},
                                           {"white metal .6", metal(1, 0.6f)},
                                           {"thin clear", glass(1, 0, 1, false)},
                                           {"thin half", glass(1, 0, 0.5f, false)},
                                           {"thin rough", glass(1, 0.5f, 1, false)},
                                           {"clear volume", glass(1, 0, 1, true)},
                                           {"half volume", glass(1, 0, 0.5f, true)},
                                           {"rough volume .3", glass(1, 0.3f, 1, true)},
                                           {"rough volume .8", glass(1, 0.8f, 0.5f, true)},
                                           {"rough volume of ior 1", glass(1, 0.4f, 1, true, 1.f)}};
  const bool exactly_one[] = {true, true, true, true, false, true, true, false, true, true, false, false, true};
  const BsdfProbe probe(list);
  const uint n = sample_count();
  const double t = student_t_quantile(sidak_level(0.01, 2 * list.size()), replicates - 1);
  ClosedForms table;
  for (uint m = 0; m < list.size(); ++m) {
    for (const uint back : {0u, 1u}) {
      CAPTURE(list[m].name);
      CAPTURE(back);
      const auto weights = test_buffer<float4>(n);
      probe.run("sample_cosine_views", n, 64, [&](PassBuilder& pass) {
        pass.arg("triangle", m).arg("back", back).arg("seed", 9u).arg("replicates", replicates).arg("count", n);
        pass.arg("weights", weights);
      });
      const Estimate e = estimate(weights.download());
      CHECK(e.mean <= 1 + t * e.error + 2e-4);
      if (exactly_one[m]) table.add(list[m].name + (back ? ", back" : ", front"), e, 1);
    }
  }
  table.check();
}

TEST_CASE("the BSDF is reciprocal, with squared indices for refraction") {
  const std::vector<NamedMaterial> list = {{"Lambert", dielectric(0.5f, 0.5f, 1)},
                                           {"metal", metal(0.8f, 0.3f)},
                                           {"dielectric", dielectric(0.5f, 0.4f)},
                                           {"bumped", dielectric(0.5f, 0.4f), glm::vec3(0.3f, 0.1f, 1)},
                                           {"thin", glass(0.9f, 0.4f, 0.7f, false)},
                                           {"volume", glass(0.9f, 0.5f, 0.7f, true)},
                                           {"bumped volume", glass(0.9f, 0.5f, 0.7f, true), glm::vec3(0.3f, 0.1f, 1)}};
  const BsdfProbe probe(list);
  const uint n = 4096;
  for (uint m = 0; m < list.size(); ++m) {
    CAPTURE(list[m].name);
    const auto values = test_buffer<float2>(n);
    probe.run("evaluate_both_ways", n, 64, [&](PassBuilder& pass) {
      pass.arg("triangle", m).arg("seed", 4u).arg("count", n).arg("values", values);
    });
    int positive = 0, unequal = 0;
    for (const float2& v : values.download()) {
      positive += v.x > 0;
      unequal += !(std::abs(v.x - v.y) <= 1e-3f * (v.x + v.y) + 1e-6f);
    }
    CHECK(positive > static_cast<int>(n) / 4);
    CHECK(unequal == 0);
  }
}

TEST_CASE("ideal lobes: mirrors reflect, glass branches by Fresnel and scales radiance") {
  const BsdfProbe probe({{"mirror", metal(0.8f, 0.02f)},
                         {"volume", glass(1, 0, 1, true)},
                         {"thin", glass(0.5f, 0, 1, false)},
                         {"lambert only", dielectric(0.5f, 0.f)},
                         {"lambert only, transmissive", glass(0.7f, 0, 0.6f, false)}});
  const glm::vec3 view = direction_at(0.6, 0.2);
  const double schlick = std::pow(0.4, 5);
  const auto mirror = probe.sample(0, view, 64, 1);
  for (uint i = 0; i < 64; ++i) {
    CHECK(static_cast<int>(mirror.weights[i].w) == 1);
    CHECK(glm::distance(mirror.directions[i].xyz(), glm::vec3(-view.x, -view.y, view.z)) < 1e-6f);
    CHECK(mirror.weights[i].y == test::relative(0.8 + 0.2 * schlick, 1e-5));
  }
  CHECK(probe.evaluate(0, view, glm::vec3(-view.x, -view.y, view.z)).y == 0);  // evaluated, an ideal lobe is nothing

  // Glass from outside: F of the events reflect with weight 1, the others refract with (1 / 1.5)^2.
  const uint n = 1 << 16;
  const double fresnel = 0.04 + 0.96 * schlick;
  const auto outside = probe.sample(1, view, n, 2);
  uint reflected = 0;
  for (uint i = 0; i < n; ++i) {
    const bool transmitted = static_cast<int>(outside.weights[i].w) == 3;
    reflected += !transmitted;
    REQUIRE(outside.weights[i].y == test::relative(transmitted ? 1 / 2.25 : 1.0, 1e-4));
    const glm::vec3 d = outside.directions[i].xyz();
    if (transmitted) REQUIRE(glm::distance(glm::vec2(d), -glm::vec2(view) / 1.5f) < 1e-6f);
    REQUIRE((d.z < 0) == transmitted);
  }
  CHECK(std::abs(double(reflected) / n - fresnel) < 5 * std::sqrt(fresnel / n));

  // From inside: total reflection beyond the critical angle (cosine .745), else Fresnel's cosine is the outer one.
  const auto grazing = probe.sample(1, direction_at(-0.7, 0.2), 64, 3);
  for (uint i = 0; i < 64; ++i) {
    CHECK(static_cast<int>(grazing.weights[i].w) == 1);
    CHECK(grazing.weights[i].y == test::relative(1));
    CHECK(grazing.directions[i].z == test::relative(-0.7));
  }
  const double outer_cosine = std::sqrt(1 - 2.25 * (1 - 0.81));
  const auto inside = probe.sample(1, direction_at(-0.9, 0.2), n, 3);
  reflected = 0;
  for (uint i = 0; i < n; ++i) {
    const bool transmitted = static_cast<int>(inside.weights[i].w) == 3;
    reflected += !transmitted;
    REQUIRE(inside.weights[i].y == test::relative(transmitted ? 2.25 : 1.0, 1e-4));
    if (transmitted) REQUIRE(inside.directions[i].z == test::relative(outer_cosine, 1e-4));
  }
  const double inner = 0.04 + 0.96 * std::pow(1 - outer_cosine, 5);
  CHECK(std::abs(double(reflected) / n - inner) < 5 * std::sqrt(inner / n));

  // A thin wall goes straight on, tinted.
  const auto thin = probe.sample(2, view, n, 4);
  for (uint i = 0; i < n; ++i)
    if (static_cast<int>(thin.weights[i].w) == 3) REQUIRE(glm::distance(thin.directions[i].xyz(), -view) < 1e-6f);
  ClosedForms tinted;
  tinted.add("thin wall", estimate(thin.weights), fresnel + 0.5 * (1 - fresnel));
  tinted.check(2e-3);

  // The option for secondary vertices keeps the diffuse lobe as it is: no ideal events, no specular light, nothing
  // transmitted.
  const double below_coat = 1 - (0.04 * (1 - 1.0 / 21) + 1.0 / 21);
  for (const auto& [material, albedo] : {std::pair{3u, 0.5}, std::pair{4u, 0.4 * 0.7}}) {
    CAPTURE(material);
    const auto lambert = probe.sample(material, view, 64, 5, 1, 1);
    for (uint i = 0; i < 64; ++i) {
      CHECK(static_cast<int>(lambert.weights[i].w) == 0);
      CHECK(lambert.weights[i].y == test::relative(albedo * below_coat, 1e-4));
    }
  }
}

TEST_CASE("black: backs of single-sided surfaces, unlit materials, directions on which the normals disagree") {
  SceneMaterial single = dielectric(0.5f, 0.5f), unlit = dielectric(0.5f, 0.5f);
  single.double_sided = false;
  unlit.unlit = true;
  const BsdfProbe probe({{"single", single},
                         {"unlit", unlit},
                         {"double", dielectric(0.5f, 0.5f)},
                         {"bumped", dielectric(0.5f, 0.5f), glm::vec3(1, 0, 1)}});
  const glm::vec3 up(0, 0, 1), down(0, 0, -1), side = direction_at(0.5, 0);
  CHECK(probe.evaluate(0, up, side).y > 0);
  CHECK(probe.evaluate(0, down, -side).y == 0);
  CHECK(probe.evaluate(1, up, side).y == 0);
  CHECK(probe.evaluate(2, down, -side).y == test::relative(probe.evaluate(2, up, side).y));
  CHECK(probe.evaluate(2, up, -side).y == 0);
  for (const uint m : {0u, 1u}) {
    const auto samples = probe.sample(m, m == 0 ? down : up, 64, 1);
    for (const float4& weight : samples.weights) CHECK(weight.y == 0);
  }
  // n_s leans by 45 degrees towards +x: (-.9, 0, .4) is above the triangle but behind n_s, (.99, 0, -.1) the reverse.
  CHECK(probe.evaluate(3, up, glm::normalize(glm::vec3(-0.9f, 0, 0.4f))).y == 0);
  CHECK(probe.evaluate(3, up, glm::normalize(glm::vec3(0.99f, 0, -0.1f))).y == 0);
  CHECK(probe.evaluate(3, up, glm::normalize(glm::vec3(0.9f, 0, 0.4f))).y > 0);
}

TEST_CASE("material parameters are read from the channels of their textures that glTF names") {
  // One texel (51, 102, 204): transmission in R, roughness in G, metallic in B, times the factors.
  SceneMaterial textured = glass(0.7f, 0.9f, 0.8f, false), plain = textured;
  textured.metallic = 0.5f;
  textured.metallic_roughness_texture.texture = textured.transmission_texture.texture = 0;
  plain.metallic = 0.5f * 204 / 255, plain.roughness = 0.9f * 102 / 255, plain.transmission = 0.8f * 51 / 255;
  Scene scene = material_scene({{"textured", textured}, {"plain", plain}});
  scene.images.push_back({"parameters", 1, 1, {51, 102, 204, 255}});
  scene.textures = {{0, Wrap::repeat, Wrap::repeat, false, false}};
  const BsdfProbe probe(scene);
  const glm::vec3 view = direction_at(0.8, 0.1);
  for (const glm::vec3& light : {direction_at(0.7, 0.55), direction_at(0.3, 0.2), direction_at(-0.75, 0.6)}) {
    const float4 expected = probe.evaluate(1, view, light), found = probe.evaluate(0, view, light);
    CHECK(expected.y > 1e-3f);
    CHECK(found.y == test::relative(expected.y, 1e-4));
    CHECK(found.w == test::relative(expected.w, 1e-4));
  }
}

TEST_CASE("volumes absorb by Beer's law along segments inside them") {
  SceneMaterial coloured = glass(1, 0, 1, true), thin = glass(1, 0, 1, false);
  coloured.attenuation_distance = thin.attenuation_distance = 2;
  coloured.attenuation_color = thin.attenuation_color = glm::vec3(0.5f, 0.25f, 1);
  const BsdfProbe probe({{"volume", coloured}, {"thin", thin}, {"opaque", dielectric(0.5f, 0.5f)}});
  const auto cross = [&](uint triangle, float z, uint medium) {
    const auto value = test_buffer<float4>(1);
    probe.run("cross_medium", 1, 1, [&](PassBuilder& pass) {
      pass.arg("triangle", triangle).arg("view", float4(0, 0, z, 0)).arg("medium", medium).arg("metres", 4.f);
      pass.arg("value", value);
    });
    return value.download()[0];
  };
  const uint air = LUCARIUM_NONE, volume = 0;
  const auto check = [](const float4& got, bool absorbed, float behind) {
    CHECK(got.x == test::relative(absorbed ? 0.25 : 1));
    CHECK(got.y == test::relative(absorbed ? 0.0625 : 1));
    CHECK(got.z == test::relative(1));
    CHECK(got.w == behind);
  };
  check(cross(0, 1, air), false, 1);     // into the volume
  check(cross(0, -1, volume), true, 0);  // and out of it
  check(cross(0, -1, air), true, 0);     // seen from inside, whatever the path believes
  check(cross(1, 1, air), false, 0);     // thin walls have no inside
  check(cross(1, -1, air), false, 0);
  check(cross(2, 1, volume), true, 1);  // a thing within the volume
}
