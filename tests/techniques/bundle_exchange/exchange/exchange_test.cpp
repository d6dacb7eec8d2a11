// SPDX-License-Identifier: Apache-2.0
// The exchange along bundles against closed forms: uniform fields, form factors, a double-sided plate. What is tested
// is both estimators: the ratio that the technique uses, and W A_p / A_t times the sum, which a wrong W would change.
#include <doctest/doctest.h>

#include <cmath>

#include "lamp_room.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/load/load_scene.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

Scene closed_box() {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  return test::box_scene({white, white, white, white, white, white}, std::move(scene));
}

/// Two unit squares that see each other, at distance 1, or with a common edge.
Scene two_squares(bool parallel) {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
  add_instance(
      scene,
      add_mesh(scene, MeshBuilder("other").box_face({0, 0, 0}, {1, 1, 1}, parallel ? 1 : 0, parallel, true).take()),
      white);
  return scene;
}

Scene double_sided_plate() {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  scene.materials[white].double_sided = true;
  add_instance(scene, add_mesh(scene, MeshBuilder("plate").quad({0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}).take()),
               white);
  return scene;
}

DirectionSequence directions(int block) {
  Parameters parameters;
  parameters.block = block;
  return make_sequence(parameters, 7);
}

}  // namespace

TEST_CASE("in a closed box of radiance 1 every texel side holds exactly that, whatever the directions") {
  for (const float access_gap : {0.f, 2.f, 8.f}) {
    CAPTURE(access_gap);
    Parameters parameters;
    parameters.access_gap = access_gap;
    test::BundleRig rig(closed_box(), 1536, 0.5f, {}, parameters);
    rig.send([](uint32_t) { return glm::vec3(1, 2, 4); });
    const int count = test::full_run() ? 10240 : 512;
    rig.run(directions(2048), count);
    const std::vector<glm::dvec4> sums = rig.sums();
    const std::vector<AtlasTexel> texels = rig.texels();
    const std::vector<float> accessibility = rig.accessibility();
    double worst = 0, flux = 0, area = 0, counted = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      REQUIRE(sums[side].w > 0);
      worst = std::max(worst, std::abs(sums[side].x / sums[side].w - 1.0));
      worst = std::max(worst, std::abs(sums[side].z / sums[side].w - 4.0));
      flux += sums[side].x;
      area += texels[side].area;
      counted += double{texels[side].area} * double{accessibility[side]};
    }
    CHECK(area == test::relative(6, 1e-5));
    CHECK(worst < 1e-5);
    // E = W A_p / A_t sum L: over the whole box π per area, by accessibility. Along ω the box shows |ω_x| + |ω_y| +
    // |ω_z|, in the mean 3 / 2. Accessibility is measured by other rays.
    double shown = 0;
    for (int i = 0; i < count; ++i)
      shown += glm::dot(glm::abs(glm::dvec3(directions(2048).at(i).direction)), glm::dvec3(1)) / count;
    MESSAGE("flux ", flux / count / counted, ", of the directions ", pi * shown / 1.5, ", accessibility ",
            counted / area);
    if (access_gap > 0) {
      // Near edges and corners rays are short.
      std::mt19937_64 random(1);
      std::uniform_real_distribution<double> unit;
      double open = 0;
      const int rays = 2000000;
      for (int i = 0; i < rays; ++i) {
        const test::lamp_room::WallPoint from{i % 6, unit(random), unit(random)};
        const glm::dvec3 to = test::lamp_room::cosine_direction(from.wall, {unit(random), unit(random)});
        open += test::lamp_room::trace(from.position(), to).distance > double{access_gap} * rig.texel_edge();
      }
      MESSAGE("open ", open / rays, ", counted ", counted / area);
      CHECK(counted / area == test::relative(open / rays, 0.002));
      CHECK(flux / count / counted == test::relative(pi, 2e-3));
    } else {
      CHECK(counted == test::relative(area, 1e-6));
      CHECK(flux / count / counted == test::relative(pi, test::full_run() ? 1e-4 : 5e-4));
    }
  }
}

TEST_CASE("in a closed box with a slit, smaller than the gap, every texel side holds light") {
  // Next to no ray leaves by the slit, which is a fiftieth of a wall; the room around the box is as bright.
  constexpr float low = 0.8f, high = 1.2f, slit = 0.008f;
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  const auto add = [&](MeshBuilder mesh) { add_instance(scene, add_mesh(scene, std::move(mesh).take()), white); };
  for (int face = 0; face < 6; ++face)
    add(MeshBuilder("room").box_face({0, 0, 0}, {2, 2, 2}, face / 2, face % 2, true));
  for (int face = 1; face < 6; ++face)
    add(MeshBuilder("box").box_face(glm::vec3(low), glm::vec3(high), face / 2, face % 2, true));
  add(MeshBuilder("wall").quad({low, low, low + slit}, {low, high, low + slit}, {low, high, high}, {low, low, high}));
  Parameters parameters;
  parameters.access_gap = 16;
  test::BundleRig rig(std::move(scene), 6000, 0.5f, {}, parameters);
  REQUIRE(16 * rig.texel_edge() > std::sqrt(3) * double{high - low});
  rig.send([](uint32_t) { return glm::vec3(1); });
  rig.run(directions(512), 512);
  const std::vector<glm::dvec4> sums = rig.sums();
  const std::vector<AtlasTexel> texels = rig.texels();
  uint32_t inside = 0, dark = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (rig.instance_of(texels[side].triangle) < 6) continue;
    ++inside;
    dark += !(sums[side].w > 0) || std::abs(sums[side].x / sums[side].w - 1.0) > 1e-5;
  }
  MESSAGE(dark, " of ", inside, " are dark; mean accessibility ", rig.accessibility().back());
  CHECK(inside > 200);
  CHECK(dark == 0);
}

TEST_CASE("bundle pixels are no smaller than a sixteenth of the longest texel") {
  // Squares of 1/8: their diagonals.
  test::BundleRig box(closed_box(), 384, 0.05f);
  CHECK(box.texel_extent(0) == test::relative(std::sqrt(2) / 8, 0.003));
  CHECK(box.bundle_pixel() == test::relative(std::sqrt(2) / 8 / 16, 0.003));
  // Spheres have texels of all shapes; random points of them are nearly as far apart as points can be.
  for (const float pixel_size : {0.1f, 0.5f}) {
    test::BundleRig spheres(load_scene("builtin:spheres"), 2048, pixel_size);
    const double extent = spheres.texel_extent(0), sampled = spheres.sampled_extent(), edge = spheres.texel_edge();
    MESSAGE("longest texel ", extent / edge, " edges, between samples ", sampled / edge, ", bundle pixel ",
            spheres.bundle_pixel() / edge);
    CHECK(extent >= sampled);
    CHECK(extent < 1.5 * sampled);
    CHECK(spheres.bundle_pixel() == test::relative(std::max(double(pixel_size) * edge, extent / 16), 1e-6));
  }
}

TEST_CASE("bundle pixels are chosen for texels as they are, not as they were when the atlas was made") {
  test::BundleRig box(closed_box(), 384, 0.5f);  // squares of 1/8
  CHECK(box.bundle_pixel() == test::relative(0.5 / 8, 0.02));
  const double stretched = box.bundle_pixel_after([](Scene& scene) {
    SceneChange change;
    SceneInstance& wall = scene.instances.back();
    change.moved_instances = {static_cast<int>(scene.instances.size()) - 1};
    change.previous_world_from_object = {wall.world_from_object};
    wall.world_from_object[0] *= 12.f;
    return change;
  });
  CHECK(stretched == test::relative(std::sqrt(12 * 12 + 1) / 8 / 16, 0.003));
}

TEST_CASE("form factors of unit squares") {
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    Parameters alike;  // all parts of texels count alike
    alike.access_gap = 0;
    test::BundleRig rig(two_squares(parallel), 512, 0.5f, {}, alike);
    const std::vector<AtlasTexel> texels = rig.texels();
    std::vector<bool> lamp;
    for (const AtlasTexel& texel : texels) lamp.push_back(rig.instance_of(texel.triangle) == 0);
    rig.send([&](uint32_t side) { return glm::vec3(lamp[side] ? 1.f : 0.f); });
    const int count = test::full_run() ? 10240 : 2048;
    rig.run(directions(2048), count);
    const std::vector<glm::dvec4> sums = rig.sums();
    double received = 0, weight = 0, flux = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      if (lamp[side]) continue;
      received += sums[side].x;
      weight += sums[side].w;
      flux += sums[side].x;
    }
    const double expected = parallel ? 0.19982 : 0.20004, tolerance = test::full_run() ? 3e-4 : 1e-3;
    CHECK(std::abs(received / weight - expected) < tolerance);
    CHECK(std::abs(flux / count / pi - expected) < tolerance);
  }
}

TEST_CASE("a double-sided plate under a sky of radiance 1 + w_y: 5 pi / 3 above, pi / 3 below") {
  Scene scene = double_sided_plate();
  Environment sky;
  sky.width = 256, sky.height = 128;
  for (uint32_t j = 0; j < sky.height; ++j)
    for (uint32_t i = 0; i < sky.width; ++i)
      sky.radiance.push_back(glm::vec3(static_cast<float>(1 + std::cos(pi * (j + 0.5) / sky.height))));
  scene.environment = sky;
  Channels channels;
  channels.emission = true;
  for (const float guiding : {0.f, 0.5f}) {
    CAPTURE(guiding);
    test::BundleRig rig(scene, 128, 0.5f, channels);
    rig.send([](uint32_t) { return glm::vec3(0); });
    Parameters parameters;
    parameters.env_guiding = guiding;
    const int count = test::full_run() ? 8192 : 2048;
    rig.run(make_sequence(parameters, 3, make_environment_guide(&*scene.environment)), count);
    const std::vector<glm::dvec4> sums = rig.sums();
    const std::vector<SurfacePoint> points = rig.points();
    double ratio[2][2] = {}, flux[2] = {};
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      const int up = points[side].normal.y > 0;
      ratio[up][0] += sums[side].x;
      ratio[up][1] += sums[side].w;
      flux[up] += sums[side].x / count;
    }
    const double exact[2] = {pi / 3, 5 * pi / 3};
    for (int up = 0; up < 2; ++up) {
      CHECK(pi * ratio[up][0] / ratio[up][1] == test::relative(exact[up], 0.005));
      CHECK(flux[up] == test::relative(exact[up], 0.01));
    }
  }
}
