// SPDX-License-Identifier: Apache-2.0
// Fields that are not even, in which wrong weights do not cancel: what is sent is what is received, hidden places
// change nothing of what is seen, and the sides of a sheet are two surfaces.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "bundle_rig.h"
#include "lucarium/base/numbers.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

/// What a place sends: brighter towards +x, and by the instance that it is of.
glm::vec3 uneven(const SurfacePoint& point, uint32_t instance) {
  return glm::vec3(0.2f + 2 * point.position.x + (instance % 3 == 0 ? 1.5f : 0.f), 1, 0);
}

/// A hall with a block on its floor and a ceiling that shines. `through`: the block goes on below the floor, which goes
/// on below the block.
Scene hall_with_block(bool through) {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f)), lamp = add_emitter(scene, "lamp", glm::vec3(1));
  const auto add = [&](MeshBuilder mesh, int material = 0) {
    add_instance(scene, add_mesh(scene, std::move(mesh).take()), material);
  };
  for (int face = 0; face < 6; ++face)
    if (face != 2)
      add(MeshBuilder("wall").box_face({0, 0, 0}, {1, 1, 1}, face / 2, face % 2, true), face == 3 ? lamp : white);
  for (int face = 0; face < 6; ++face)
    if (face != 2 || through)
      add(MeshBuilder("block").box_face({0.31f, through ? -0.1f : 0.f, 0.37f}, {0.58f, 0.3f, 0.61f}, face / 2, face % 2,
                                        false));
  const auto quad = [](MeshBuilder& mesh, float x0, float z0, float x1, float z1) {
    mesh.quad({x0, 0, z0}, {x0, 0, z1}, {x1, 0, z1}, {x1, 0, z0});
  };
  MeshBuilder floor("floor");
  if (through) {
    quad(floor, 0, 0, 1, 1);
  } else {
    quad(floor, 0, 0, 1, 0.37f);
    quad(floor, 0, 0.37f, 0.31f, 0.61f);
    quad(floor, 0.58f, 0.37f, 1, 0.61f);
    quad(floor, 0, 0.61f, 1, 1);
  }
  add(std::move(floor));
  return scene;
}

/// Of all that is seen of the floor: mean of what it receives, and of the ceiling's light; what its area counts.
struct Floor {
  double light, sampled, counted;
};
Floor light_of_floor(bool through, Transfer transfer) {
  Parameters parameters;
  parameters.transfer = transfer;
  test::BundleRig rig(hall_with_block(through), 1500, 0.5f, {}, parameters);
  const std::vector<SurfacePoint> points = rig.points();
  const std::vector<AtlasTexel> texels = rig.texels();
  std::vector<uint32_t> instance;
  for (const AtlasTexel& texel : texels) instance.push_back(rig.instance_of(texel.triangle));
  const uint32_t floor = *std::max_element(instance.begin(), instance.end());
  rig.send([&](uint32_t side) { return instance[side] == 1 ? glm::vec3(4) : uneven(points[side], 1); });
  rig.run(make_sequence(parameters, 5), 512);
  const std::vector<glm::dvec4> sums = rig.sums();
  const std::vector<float2> interior = rig.interior();
  const std::vector<float> accessibility = rig.accessibility();
  const std::vector<double> sampled = rig.sampled_light(64);
  double sum = 0, sampled_sum = 0, area = 0, counted = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (instance[side] == floor) counted += double{texels[side].area} * double{accessibility[side]};
    if (instance[side] != floor || !(sums[side].w > 0) || !(interior[side].x > 0)) continue;
    const double seen = double{texels[side].area} * double{interior[side].x};
    sum += seen * sums[side].x / sums[side].w;
    sampled_sum += seen * sampled[side];
    area += seen;
  }
  CHECK(area == test::relative(1 - 0.27 * 0.24, 0.02));
  return {sum / area, sampled_sum / area, counted};
}

Scene plate(bool twice) {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.5f));
  const auto floor = [&] {
    add_instance(scene, add_mesh(scene, MeshBuilder("floor").box_face({0, 0, 0}, {1, 1, 1}, 1, 0, true).take()), white);
  };
  add_instance(scene, add_mesh(scene, MeshBuilder("other").box_face({0, 0, 0}, {1, 1, 1}, 1, 1, true).take()), white);
  floor();
  if (twice) floor();
  return scene;
}

}  // namespace

TEST_CASE("what texel sides send along all rays is what texel sides receive, whatever their parts count") {
  Scene scene;
  const int white = add_lambert(scene, "white", glm::vec3(0.8f));
  scene = test::box_scene({white, white, white, white, white, white}, std::move(scene));
  test::BundleRig rig(scene, 600, 0.5f);
  const std::vector<SurfacePoint> points = rig.points();
  const std::vector<AtlasTexel> texels = rig.texels();
  std::vector<float> sent;
  for (uint32_t side = 0; side < rig.sides(); ++side)
    sent.push_back(uneven(points[side], rig.instance_of(texels[side].triangle)).x);
  rig.send([&](uint32_t side) { return glm::vec3(sent[side]); });
  rig.run(make_sequence({}, 5), 32);
  const std::vector<glm::dvec4> sums = rig.sums();
  const std::vector<double> counted = rig.counted();
  double delivered = 0, received = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    delivered += counted[side] * double{sent[side]};
    received += sums[side].x;
  }
  CHECK(delivered == test::relative(received, 1e-5));
}

TEST_CASE("a floor that goes on below a block receives in an uneven field what one receives that ends at it") {
  for (const Transfer transfer : {Transfer::ray, Transfer::texel}) {
    CAPTURE(int(transfer));
    const Floor through = light_of_floor(true, transfer), cut = light_of_floor(false, transfer);
    MESSAGE("through ", through.light, " ", through.sampled, " (", through.counted, "), cut ", cut.light, " ",
            cut.sampled, " (", cut.counted, ")");
    CHECK(through.sampled == test::relative(cut.sampled, 0.01));
    CHECK(through.light == test::relative(cut.light, 0.01));
    CHECK(through.counted == test::relative(cut.counted, 0.02));
  }
}

TEST_CASE("below a sheet is seen what its back sends, above it what its front sends") {
  for (const Transfer transfer : {Transfer::ray, Transfer::texel}) {
    CAPTURE(int(transfer));
    Scene scene;
    const int white = add_lambert(scene, "white", glm::vec3(0.5f)),
              sheet = add_lambert(scene, "sheet", glm::vec3(0.5f));
    scene.materials[sheet].double_sided = true;
    for (const int side : {0, 1})  // a floor and a ceiling that face each other
      add_instance(scene, add_mesh(scene, MeshBuilder("wall").box_face({0, -1, 0}, {1, 1, 1}, 1, side, true).take()),
                   white);
    add_instance(scene, add_mesh(scene, MeshBuilder("sheet").quad({0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}).take()),
                 sheet);
    Parameters parameters;
    parameters.transfer = transfer;
    parameters.access_gap = 0;
    for (const bool front : {true, false}) {
      CAPTURE(front);
      test::BundleRig rig(scene, 1000, 0.5f, {}, parameters);
      const std::vector<SurfacePoint> points = rig.points();
      rig.send([&](uint32_t side) {
        const bool is_sheet = std::abs(points[side].position.y) < 0.5f;
        return glm::vec3(is_sheet && (points[side].normal.y > 0) == front ? 1.f : 0.f);
      });
      rig.run(make_sequence(parameters, 7), 1024);
      double received[2] = {}, weight[2] = {};
      for (uint32_t side = 0; side < rig.sides(); ++side) {
        if (std::abs(points[side].position.y) < 0.5f) continue;
        received[points[side].position.y > 0] += rig.sums()[side].x;
        weight[points[side].position.y > 0] += rig.sums()[side].w;
      }
      CHECK(received[front] / weight[front] == test::relative(0.19982, 0.015));
      CHECK(received[!front] == 0);
    }
  }
}

TEST_CASE("a surface drawn twice in one place sends and receives once") {
  Parameters alike;  // all parts of texels count alike
  alike.access_gap = 0;
  test::BundleRig rig(plate(true), 700, 0.5f, {}, alike);
  const std::vector<AtlasTexel> texels = rig.texels();
  std::vector<bool> ceiling, copy;
  for (const AtlasTexel& texel : texels) {
    ceiling.push_back(rig.instance_of(texel.triangle) == 0);
    copy.push_back(rig.instance_of(texel.triangle) == 2);
  }
  for (const bool from_ceiling : {false, true}) {
    CAPTURE(from_ceiling);
    rig.send([&](uint32_t side) { return glm::vec3(ceiling[side] == from_ceiling ? 1.f : 0.f); });
    const std::vector<glm::dvec4> before = rig.sums();
    const int count = 1024;
    rig.run(make_sequence(alike, 7), count);
    double received = 0, weight = 0, copied = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      if (ceiling[side] == from_ceiling) continue;
      const glm::dvec4 found = rig.sums()[side] - (before.empty() ? glm::dvec4(0) : before[side]);
      if (copy[side]) copied += found.w;
      received += found.x;
      weight += found.w;
    }
    CHECK(copied == 0);  // rays hit the first one, from either end
    CHECK(received / weight == test::relative(0.19982, 0.01));
    CHECK(received / count / pi == test::relative(0.19982, 0.01));  // W A_p Σ L over a square metre
  }
}

TEST_CASE("the sides of a sheet are lit, seen in mirrors and send apart from each other") {
  // A mirror faces the back of a sheet at distance 1/2, and shows it at distance 1.
  Scene scene;
  const int mirror = add_metal(scene, "mirror", glm::vec3(1), 0), white = add_lambert(scene, "white", glm::vec3(0.5f));
  scene.materials[white].double_sided = true;
  add_instance(
      scene,
      add_mesh(scene,
               MeshBuilder("mirror").quad({-.2f, 0, -.2f}, {-.2f, 0, 1.2f}, {1.2f, 0, 1.2f}, {1.2f, 0, -.2f}).take()),
      mirror);
  add_instance(scene,
               add_mesh(scene, MeshBuilder("sheet").quad({0, .5f, 0}, {0, .5f, 1}, {1, .5f, 1}, {1, .5f, 0}).take()),
               white);
  Channels channels;
  channels.chains = true;
  channels.self_fed = false;
  channels.count = 2;  // reflected by the sheet, and by sheet and mirror
  Parameters parameters;
  parameters.chain_share = 0.3f;  // less than all chains, each counting more
  parameters.access_gap = 0;
  for (const bool lit_up : {true, false}) {
    CAPTURE(lit_up);
    test::BundleRig rig(scene, 6000, 0.5f, channels, parameters);
    const std::vector<SurfacePoint> points = rig.points();
    const auto is_sheet = [&](uint32_t side, bool up) {
      return points[side].position.y > 0.4f && (points[side].normal.y > 0) == up;
    };
    rig.set_direct([&](uint32_t side) { return is_sheet(side, lit_up) ? float(pi) : 0.f; });
    rig.solve(make_sequence(parameters, 3), 2048);
    const std::vector<double> found = rig.indirect();
    CHECK(rig.mean(found, [&](uint32_t side) { return is_sheet(side, true); }) == 0);  // it sees nothing
    // Form factor of squares at distance 1 times what the lit back sends.
    const double below = rig.mean(found, [&](uint32_t side) { return is_sheet(side, false); });
    MESSAGE("below ", below);
    if (lit_up)
      CHECK(below == 0);
    else
      CHECK(below == test::relative(0.5 * 0.19982, 0.01));
  }
}
