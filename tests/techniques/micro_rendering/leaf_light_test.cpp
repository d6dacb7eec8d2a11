// SPDX-License-Identifier: Apache-2.0
// The forest on the device: what contains what, before and after a deformation; light of several bounces in a sphere.
#include "micro_rendering/light/leaf_light.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/services/bvh/bvh.h"
#include "micro_fixture.h"
#include "packed_node.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;
using test::PackedNode;
using test::unpack;

namespace {

float angle(const glm::vec3& a, const glm::vec3& b) { return 2 * std::atan2(glm::length(a - b), glm::length(a + b)); }

/// Children that are not inside their parents, by more than float arithmetic.
size_t violations(const PointForest& forest) {
  const std::vector<uint4> nodes = forest.nodes.download();
  size_t count = 0;
  for (const ForestTree& tree : forest.trees()) {
    for (uint32_t i = 2; i < 2 * tree.leaves(); ++i) {
      const PackedNode child = unpack(nodes[tree.record.first_node + i]),
                       parent = unpack(nodes[tree.record.first_node + i / 2]);
      count += glm::distance(child.center, parent.center) + child.radius > parent.radius * 1.00001f + 0.01f;
      count += parent.cone < 3.1415f && angle(child.normal, parent.normal) + child.cone > parent.cone + 1e-3f;
    }
  }
  return count;
}

/// A closed sphere of radius 1 seen from inside, albedo 1/2. Its facets are tilted against it by up to 0.6°: with 5120,
/// by 2.4°, what single points get differs by 1.1 % from what those of a sphere do.
Scene make_hollow_sphere() {
  Scene scene;
  scene.source = "test:sphere";
  MeshBuilder builder("sphere");
  for (const auto& t : icosphere(6)) builder.triangle(t[0], t[2], t[1]);
  add_instance(scene, add_mesh(scene, builder.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
  return scene;
}

}  // namespace

TEST_CASE("nodes contain what is below them, also after a deformation, and the tree becomes no looser by a small one") {
  Scene scene;
  scene.source = "test:two";
  MeshBuilder ball("ball");
  for (const auto& t : icosphere(3)) ball.triangle(t[0], t[1], t[2]);
  const int grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  add_instance(scene, add_mesh(scene, ball.take()), grey);
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box({-3, -2, -3}, {3, -1, 3}).take()), grey);
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  PointForest forest(device, scheduler, scene, buffers, {.points_log2 = 13}, "test");
  REQUIRE(forest.trees().size() == 2);
  CHECK(violations(forest) == 0);
  CHECK_FALSE(forest.loosened());

  SceneChange change;
  change.deformed_instances = {0};
  const auto deform = [&](float amount) {
    Mesh pose = scene.meshes[0];
    for (glm::vec3& p : pose.positions)
      p = p * glm::vec3(1 + amount, 1 - 0.5f * amount, 1) + glm::vec3(amount * p.y, 0, 0);
    scene.instances[0].pose = std::make_shared<Mesh>(std::move(pose));
    buffers.update(scene, change);
    return forest.update(change);
  };
  CHECK(deform(0.3f));
  CHECK(violations(forest) == 0);
  // Back again: the same nodes as at the beginning.
  const std::vector<uint4> bent = forest.nodes.download();
  CHECK(deform(0));
  CHECK(violations(forest) == 0);
  CHECK(forest.nodes.download()[forest.trees()[1].record.first_node + 1].y !=
        bent[forest.trees()[1].record.first_node + 1].y);
}

TEST_CASE("a pose that folds neighbours apart asks for a new tree") {
  Scene scene;
  scene.source = "test:sheet";
  MeshBuilder sheet("sheet");
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) sheet.quad({i, 0, j}, {i, 0, j + 1}, {i + 1, 0, j + 1}, {i + 1, 0, j});
  add_instance(scene, add_mesh(scene, sheet.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  PointForest forest(device, scheduler, scene, buffers, {.points_log2 = 12}, "test");
  // Every other square moves far away.
  Mesh pose = scene.meshes[0];
  for (size_t v = 0; v < pose.positions.size(); ++v)
    if (v / 4 % 2) pose.positions[v].y += 40;
  scene.instances[0].pose = std::make_shared<Mesh>(std::move(pose));
  SceneChange change;
  change.deformed_instances = {0};
  buffers.update(scene, change);
  CHECK_FALSE(forest.update(change));
  CHECK(forest.loosened());
  // A run that begins in this pose finds the same.
  CHECK(PointForest(device, scheduler, scene, buffers, {.points_log2 = 12}, "test").loosened());
  // One that is ordered as it stands now has small nodes and keeps them.
  PointForest posed(device, scheduler, scene, buffers, {.points_log2 = 12, .posed = true}, "test");
  CHECK_FALSE(posed.loosened());
  CHECK(posed.update(change));
  CHECK(violations(posed) == 0);
  const auto radii = [](const PointForest& f) {
    const MicroTree& tree = f.trees().front().record;
    double sum = 0;
    for (const uint4& node : f.nodes.download(tree.first_node + 256, 256))
      sum += static_cast<double>(unpack(node).radius * tree.world_step);
    return sum;
  };
  CHECK(radii(forest) > 1.5 * radii(posed));  // beyond which a tree is too loose
}

TEST_CASE("light in a sphere grows bounce by bounce as the closed form says, and means are pulled") {
  // Inside a sphere every point sees every other with the same form factor: E / pi is the mean radiance. With L = 2 in
  // one half, 0 in the other, and albedo 1/2, it is 1, 1 + 1/2, 1 + 1/2 + 1/4, …
  const Scene scene = make_hollow_sphere();
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  Bvh bvh(device, scene, buffers);
  MicroParameters parameters;
  parameters.points_log2 = test::full_run() ? 16 : 13;
  parameters.micro_size = 16;
  parameters.jacobi_level = 9;
  const PointForest forest(device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test");
  const GatherPass gather(device, parameters, micro::GatherAt::nodes);
  constexpr double pi = 3.14159265358979;
  constexpr int frames = 4;  // of which one alone has a mean that is off by 0.08 %
  double expected = 0;
  for (int bounces = 2; bounces <= 5; ++bounces) {
    expected += std::pow(0.5, bounces - 2);
    LeafLight light(device, scheduler, scene, buffers, bvh, forest, gather, parameters, bounces, "test");
    double mean = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
      REQUIRE(light.receive(frame, 1));
      scheduler.finish();
      // The half follows from the leaves' places in the tree, whose root splits the sphere in the middle.
      std::vector<float4> received(forest.leaf_count(), float4(0, 0, 0, 0));
      std::fill_n(received.begin(), received.size() / 2, float4(glm::vec3(static_cast<float>(4 * pi)), 0));
      light.received().write(received.data(), received.size() * sizeof(float4));
      REQUIRE(light.spread());
      scheduler.finish();
      double sum = 0, squares = 0;
      const uint32_t count = light.nodes().count();
      CHECK(count == 512);  // nothing is bent there
      for (const float4& e : light.nodes().gathered().download(0, count)) {
        const double value = static_cast<double>(e.x) / pi;
        sum += value;
        squares += (value - expected) * (value - expected);
      }
      const double rmse = std::sqrt(squares / count) / expected;
      CAPTURE(frame);
      MESSAGE("bounce ", bounces - 1, ": RMSE ", rmse);
      CHECK(rmse < 0.04);
      mean += sum / count / frames;
      if (frame > 0) continue;
      // The root holds the mean of what the leaves show: L = received + albedo E.
      const uint2 root = forest.radiance.download(1, 1).front();
      const float unit = forest.radiance_unit.download().front();
      CHECK(unit * glm::unpackHalf1x16(static_cast<uint16_t>(root.x & 0xffffu)) ==
            test::relative(1 + 0.5 * sum / count, 0.002));
      CHECK(unit * glm::unpackHalf1x16(static_cast<uint16_t>(root.y >> 16)) == test::relative(2, 0.15));
    }
    MESSAGE("bounce ", bounces - 1, ": E/pi ", mean, ", expected ", expected);
    CHECK(std::abs(mean / expected - 1) < 0.002);
  }
}

namespace {

/// The share of the upper hemisphere about `normal` at `point`, weighted by the cosine, that the square [-1, 1]^2 at y
/// = -1 fills; midpoints.
double floor_share(const glm::dvec3& point, const glm::dvec3& normal) {
  constexpr int cells = 48;
  double sum = 0;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const glm::dvec3 d = glm::dvec3((i + 0.5) * 2 / cells - 1, -1, (j + 0.5) * 2 / cells - 1) - point;
      const double d2 = glm::dot(d, d);
      sum += std::max(0.0, glm::dot(normal, d)) * std::max(0.0, -d.y) / (d2 * d2) * 4 / (cells * cells);
    }
  return sum / 3.14159265358979;
}

}  // namespace

TEST_CASE("nodes in corners gather where they are bent: leaves of a wall do not get what a floor gets") {
  // The cube [-1, 1]^3 whose floor alone shines. The floor gets nothing of it, walls the most beside it.
  Scene scene;
  scene.source = "test:cube";
  MeshBuilder box("box");
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) box.box_face({-1, -1, -1}, {1, 1, 1}, axis, side, true);
  add_instance(scene, add_mesh(scene, box.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  Bvh bvh(device, scene, buffers);
  MicroParameters parameters;
  parameters.points_log2 = 13;
  parameters.micro_size = 16;
  parameters.jacobi_level = 10;
  const PointForest forest(device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test");
  const GatherPass gather(device, parameters, micro::GatherAt::nodes);
  const std::vector<uint4> nodes = forest.nodes.download();
  const MicroTree& tree = forest.trees().front().record;
  const uint32_t count = forest.leaf_count();
  std::vector<float4> received(count, float4(0, 0, 0, 0));
  std::vector<double> expected(count);
  constexpr double pi = 3.14159265358979;
  for (uint32_t i = 0; i < count; ++i) {
    const PackedNode leaf = unpack(nodes[count + i]);
    const glm::dvec3 point =
        glm::dvec3(tree.origin_step.xyz()) + static_cast<double>(tree.origin_step.w) * glm::dvec3(leaf.center);
    const bool floor = leaf.normal.y > 0.5f;
    if (floor) received[i] = float4(glm::vec3(static_cast<float>(2 * pi)), 0);  // L = 1
    expected[i] = floor ? 2 * pi : pi * floor_share(point, leaf.normal);
  }
  struct Errors {
    uint32_t gathers;
    double all, floor;  ///< RMSE of E / pi over leaves
  };
  const auto errors = [&](float cone) {
    parameters.jacobi_cone = cone;
    LeafLight light(device, scheduler, scene, buffers, bvh, forest, gather, parameters, 2, "test");
    REQUIRE(light.receive(0, 1));
    scheduler.finish();
    light.received().write(received.data(), received.size() * sizeof(float4));
    REQUIRE(light.spread());
    scheduler.finish();
    const std::vector<float4> all = light.irradiance().download();
    double sum = 0, on_floor = 0;
    int floor = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const double square = std::pow((static_cast<double>(all[i].x) - expected[i]) / pi, 2);
      sum += square;
      if (received[i].x > 0) on_floor += square, ++floor;
    }
    return Errors{light.nodes().count(), std::sqrt(sum / count), std::sqrt(on_floor / floor)};
  };
  const Errors level = errors(180), cut = errors(30);
  MESSAGE("one level: ", level.gathers, " gathers, RMSE ", level.all, ", floor ", level.floor);
  MESSAGE("cut: ", cut.gathers, " gathers, RMSE ", cut.all, ", floor ", cut.floor);
  CHECK(level.gathers == 1024);
  CHECK(cut.gathers > 1024);
  CHECK(cut.gathers <= 2048);
  CHECK(cut.all < 0.5 * level.all);
  CHECK(cut.floor < 0.01);
  CHECK(level.floor > 0.05);
}

TEST_CASE("every leaf of a sphere gets I / R^2 of a lamp in the middle, however many samples it takes") {
  Scene scene = make_hollow_sphere();
  scene.lights.emplace_back();
  scene.lights.back().intensity = glm::vec3(3, 2, 1);
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  Bvh bvh(device, scene, buffers);
  MicroParameters parameters;
  parameters.points_log2 = 12;
  const PointForest forest(device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test");
  const GatherPass gather(device, parameters, micro::GatherAt::nodes);
  for (const int samples : {1, 4}) {
    CAPTURE(samples);
    parameters.light_samples = samples;
    LeafLight light(device, scheduler, scene, buffers, bvh, forest, gather, parameters, 1, "test");
    REQUIRE(light.receive(0, 1));
    scheduler.finish();
    for (const float4& e : light.received().download()) {
      REQUIRE(e.x == test::relative(3, 0.01));  // facets lie up to 0.2 % within the sphere
      REQUIRE(e.z == test::relative(1, 0.01));
    }
  }
}

TEST_CASE("a node's radiance is the mean of the leaves below it, its range the difference of their extremes") {
  const Scene scene = make_hollow_sphere();
  Device& device = *test::test_device();
  KernelScheduler scheduler(device.shared_from_this());
  SceneBuffers buffers(device, scene);
  Bvh bvh(device, scene, buffers);
  MicroParameters parameters;
  parameters.points_log2 = 10;
  const PointForest forest(device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test");
  const GatherPass gather(device, parameters, micro::GatherAt::nodes);
  LeafLight light(device, scheduler, scene, buffers, bvh, forest, gather, parameters, 1, "test");
  REQUIRE(light.receive(0, 1));
  scheduler.finish();
  // Any light: radiance 1/2 E / pi of another channel in every leaf, leaf j's spread over 0 … 1 without order.
  const uint32_t count = forest.leaf_count();
  std::vector<double> low(2 * count), high(2 * count), mean(2 * count), weight(2 * count);
  std::vector<float4> received(count, float4(0, 0, 0, 0));
  const std::vector<uint4> nodes = forest.nodes.download();
  for (uint32_t j = 0; j < count; ++j) {
    const double value = std::fmod(0.618034 * j, 1.0);
    (&received[j].x)[j % 3] = static_cast<float>(2 * 3.14159265358979 * value);
    const double radius = double{unpack(nodes[count + j]).radius};
    low[count + j] = high[count + j] = value;
    mean[count + j] = j % 3 == 0 ? value : 0;  // red
    weight[count + j] = radius * radius;
  }
  light.received().write(received.data(), received.size() * sizeof(float4));
  REQUIRE(light.spread());
  scheduler.finish();
  const std::vector<uint2> radiance = forest.radiance.download();
  const double unit = double{forest.radiance_unit.download().front()};
  for (uint32_t i = count - 1; i > 0; --i) {
    const uint32_t a = 2 * i, b = a + 1;
    low[i] = std::min(low[a], low[b]);
    high[i] = std::max(high[a], high[b]);
    weight[i] = weight[a] + weight[b];
    mean[i] = (weight[a] * mean[a] + weight[b] * mean[b]) / weight[i];
    CAPTURE(i);
    const auto half = [&](uint32_t bits) { return unit * double{glm::unpackHalf1x16(static_cast<uint16_t>(bits))}; };
    REQUIRE(half(radiance[i].x & 0xffffu) == test::within(mean[i], 0.004));  // 10 levels of halfs
    REQUIRE(half(radiance[i].y >> 16) == test::within(high[i] - low[i], 0.001));
  }
}

TEST_CASE("the work of a refit is in proportion to the points") {
  // Every inner node is merged once: ranges of levels [top, bottom) follow each other from the leaves to the root, and
  // 2^top work-items merge 2^(bottom - top) - 1 nodes each.
  for (uint32_t depth = 1; depth <= 23; ++depth) {
    uint64_t merged = 0;
    uint32_t reached = depth;
    PointForest::for_level_ranges(depth, [&](uint32_t top, uint32_t bottom) {
      CHECK(bottom == reached);
      CHECK(top < bottom);
      merged += (uint64_t{1} << top) * ((uint64_t{1} << (bottom - top)) - 1);
      reached = top;
    });
    CHECK(reached == 0);
    CHECK(merged == (uint64_t{1} << depth) - 1);
  }
  // And an update is one such refit: its launches are one for the leaves and one per range. Times are only shown.
  Scene scene = make_hollow_sphere();
  scene.instances[0].pose = std::make_shared<Mesh>(scene.meshes[0]);
  Device& device = *test::test_device();
  SceneBuffers buffers(device, scene);
  SceneChange change;
  change.deformed_instances = {0};
  for (const int points_log2 : test::full_run() ? std::vector{14, 16, 18, 20} : std::vector{12, 14}) {
    KernelScheduler scheduler(device.shared_from_this());
    PointForest forest(device, scheduler, scene, buffers, {.points_log2 = points_log2}, "test");
    const auto launches = [&](const std::string& pass) {
      uint64_t count = 0;
      for (const PassProfile& p : scheduler.profile().passes) count += p.name == pass ? p.count : 0;
      return count;
    };
    const uint64_t leaves_before = launches("update leaves"), refits_before = launches("refit");
    constexpr int updates = 5;
    double best = 1e9;
    for (int repeat = 0; repeat < updates; ++repeat) {
      CHECK(forest.update(change));
      best = std::min(best, forest.updating_seconds());
    }
    uint64_t ranges = 0;
    PointForest::for_level_ranges(static_cast<uint32_t>(points_log2), [&](uint32_t, uint32_t) { ++ranges; });
    CHECK(launches("update leaves") - leaves_before == updates);
    CHECK(launches("refit") - refits_before == updates * ranges);
    MESSAGE((1 << points_log2), " points: ", 1e3 * best, " ms, ", 1e9 * best / (1 << points_log2), " ns per point");
  }
}
