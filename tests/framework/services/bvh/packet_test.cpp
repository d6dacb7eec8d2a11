// SPDX-License-Identifier: Apache-2.0
// Which runs of rays become packets, and that packets find what single rays find.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/animation.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "tracer.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

Program runs_program(Device& device) {
  SourceLibrary library;
  library.add(test_services_kernels());
  return Program(device, library,
                 {.name = "test/bvh_runs", .files = {"test_services/bvh/runs.cl"}, .defines = {}, .mad_enable = false});
}

/// How many runs of 16 of these rays are traced as packets in a scene of this size [m] around the origin.
uint32_t count_packets(const std::vector<Ray>& rays, float size, uint32_t row = 0) {
  const std::shared_ptr<Device> device = Device::open();
  KernelScheduler scheduler(device);
  const Program program = runs_program(*device);
  const size_t runs = rays.size() / 16;
  const TypedBuffer<Ray> ray_buffer(*device, "test", "rays", rays);
  const TypedBuffer<uint32_t> packets(*device, "test", "packets", runs);
  ScheduleRecorder recorder = scheduler.record("find packets", "test");
  recorder.pass("find", program, "find_packets")
      .global(runs)
      .local(1)
      .arg("rays", ray_buffer)
      .arg("row", row)
      .arg("count", static_cast<uint32_t>(rays.size()))
      .arg("size", size)
      .arg("extent", size / 2)
      .arg("packets", packets);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  uint32_t sum = 0;
  for (const uint32_t packet : packets.download()) sum += packet;
  return sum;
}

/// Where the rays of a batch lie that are traced one after the other.
std::vector<uint32_t> traced_order(uint32_t row, uint32_t count) {
  const std::shared_ptr<Device> device = Device::open();
  KernelScheduler scheduler(device);
  const TypedBuffer<uint32_t> rays(*device, "test", "order", count);
  ScheduleRecorder recorder = scheduler.record("order rays", "test");
  recorder.pass("order", runs_program(*device), "order_rays")
      .global(count)
      .local(1)
      .arg("row", row)
      .arg("count", count)
      .arg("rays", rays);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  return rays.download();
}

/// The image of a camera at (0, 0, distance), row by row.
std::vector<Ray> camera_rays(uint32_t width, uint32_t height, float distance) {
  std::vector<Ray> rays;
  for (uint32_t i = 0; i < width * height; ++i) {
    const float x = (static_cast<float>(i % width) + 0.5f) / static_cast<float>(width) - 0.5f;
    const float y =
        (static_cast<float>(i / width) + 0.5f - 0.5f * static_cast<float>(height)) / static_cast<float>(width);
    rays.push_back(make_ray({0, 0, distance}, glm::normalize(glm::vec3(x, y, -1))));
  }
  return rays;
}

/// Runs of 16 parallel rays whose origins lie in a cube of the given half width around a random point of the scene's.
std::vector<Ray> parallel_runs(uint32_t runs, float half_scene, float half_run, uint32_t seed) {
  std::vector<Ray> rays;
  Random random(seed);
  for (uint32_t run = 0; run < runs; ++run) {
    const glm::vec3 direction = random.direction(), middle = random.in_cube(half_scene);
    for (int i = 0; i < 16; ++i) rays.push_back(make_ray(middle + random.in_cube(half_run), direction));
  }
  return rays;
}

size_t count_hits(const Results& results) {
  size_t hit = 0;
  for (const Hit& found : results.hits) hit += found.triangle != LUCARIUM_NO_HIT;
  return hit;
}

/// Packets find the same bits as rays alone. `single` must trace them one by one.
void check_packets(Tracer& tracer, const Bvh& single, const std::vector<const Bvh*>& others,
                   const std::vector<Ray>& rays) {
  const Results expected = tracer.trace(single, rays);
  CHECK(count_hits(expected) > rays.size() / 20);
  for (const Bvh* bvh : others) {
    const Results found = tracer.trace(*bvh, rays);
    CHECK(std::memcmp(found.hits.data(), expected.hits.data(), rays.size() * sizeof(Hit)) == 0);
    CHECK(found.occluded == expected.occluded);
  }
}

/// 40 rough bodies, every other one animated.
Scene moving_bodies() {
  const Soup soup = rough_sphere(12, 16, 5);
  Mesh mesh;
  for (const Vertex& vertex : soup.vertices) mesh.positions.push_back(vertex.position.xyz());
  mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
  for (const Triangle& t : soup.triangles) mesh.triangles.push_back({t.v0, t.v1, t.v2});
  Scene scene;
  scene.source = "test:bodies";
  scene.meshes = {mesh};
  scene.materials.resize(1);
  Random random(3);
  Animation animation;
  for (int i = 0; i < 40; ++i) {
    Node node;
    node.matrix = glm::scale(
        glm::rotate(glm::translate(glm::mat4(1), random.in_cube(10)), random.uniform(0, 6), random.direction()),
        glm::vec3(random.uniform(0.5f, 2), random.uniform(0.5f, 2), random.uniform(0.5f, 2)));
    scene.nodes.push_back(node);
    SceneInstance instance;
    instance.node = i;
    instance.mesh = instance.material = 0;
    scene.instances.push_back(instance);
    AnimationChannel channel;
    channel.node = i;
    channel.times = {0};
    channel.values = {0, 0, 0};
    if (i % 2) animation.channels.push_back(channel);
  }
  scene.animations = {animation};
  evaluate(scene, 0, none);
  return scene;
}

}  // namespace

TEST_CASE("packets are made of rays that begin close together, not of all that go the same way") {
  CHECK(count_packets(camera_rays(320, 200, 20), 20) == 320 * 200 / 16);
  CHECK(count_packets(parallel_runs(500, 10, 0.002f * 20, 1), 20) > 400);  // some have no one largest component
  CHECK(count_packets(parallel_runs(500, 10, 10, 2), 20) == 0);
  // Any single ray from elsewhere is enough.
  for (const size_t odd : {0u, 5u, 7u, 15u}) {
    std::vector<Ray> rays = camera_rays(320, 200, 20);
    for (size_t run = 0; run < rays.size(); run += 16) rays[run + odd].origin.x += 5;
    CHECK(count_packets(rays, 20) == 0);
  }
}

TEST_CASE("packets of different origins give the same bits as single rays") {
  Tracer tracer;
  const Soup soup = random_soup(5000, 61);
  const Bvh single = tracer.make(soup, BvhTraversal::scalar), wide = tracer.make(soup, BvhTraversal::wide_16),
            portable = tracer.make(soup, BvhTraversal::wide_16_portable),
            eight = tracer.make(soup, BvhTraversal::wide_8);
  check_packets(tracer, single, {&wide, &portable, &eight}, parallel_runs(1000, 10, 0.04f, 62));
  check_packets(tracer, single, {&wide, &portable, &eight}, parallel_runs(1000, 10, 10, 63));
}

TEST_CASE("packets along diagonal axes and with mixed largest components give the same bits as single rays") {
  // Rays from one point on a grid of directions about each diagonal, and about each axis: within runs the largest
  // component and the signs change.
  Tracer tracer;
  Soup soup = random_soup(5000, 67);
  for (Vertex& vertex : soup.vertices) vertex.position.y *= 0.5f;
  const Bvh single = tracer.make(soup, BvhTraversal::scalar), wide = tracer.make(soup, BvhTraversal::wide_16),
            portable = tracer.make(soup, BvhTraversal::wide_16_portable),
            eight = tracer.make(soup, BvhTraversal::wide_8);
  std::vector<Ray> rays;
  for (const glm::vec3& middle : {glm::vec3(1, 1, 1),
                                  {-1, 1, 1},
                                  {1, -1, -1},
                                  {1, 1, 0},
                                  {0, -1, 1},
                                  {-1, 0, 1},
                                  {1, 0, 0},
                                  {0, -1, 0},
                                  {0, 0, 1}}) {
    const glm::vec3 other = std::abs(middle.x) > 0 ? glm::vec3(0, 0.7f, 1) : glm::vec3(1, 0.2f, 0);
    const glm::vec3 right = glm::normalize(glm::cross(middle, other)), up = glm::normalize(glm::cross(right, middle));
    for (int i = 0; i < 64 * 40; ++i) {
      const float x = 0.006f * (static_cast<float>(i % 64) - 29.3f), y = 0.02f * (static_cast<float>(i / 64) - 20);
      const glm::vec3 direction = glm::normalize(glm::normalize(middle) + x * right + y * up);
      rays.push_back(make_ray(glm::vec3(0.3f, -0.2f, 0.1f) - 12.f * glm::normalize(middle), direction));
      if (i % 64 == 0 && i / 64 % 4 == 0) rays.back().direction = float4(glm::normalize(middle), INFINITY);
    }
  }
  check_packets(tracer, single, {&wide, &portable, &eight}, rays);
}

TEST_CASE("packets of parallel rays meet a wall where its boxes meet") {
  // The rays of a run differ along one axis alone, so that the packet's slabs of the others have no slack but their
  // margin; they aim at the lines of a grid, whose triangles have boxes without thickness.
  Tracer tracer;
  constexpr int cells = 24;
  constexpr float x = 7.3f, edge = 0.37f;
  const auto line = [&](int i) { return edge * static_cast<float>(i) - 4.1f; };
  Soup soup;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const glm::vec3 a(x, line(i), line(j)), b(x, line(i + 1), line(j)), c(x, line(i + 1), line(j + 1));
      soup.add_triangle(a, b, c);
      soup.add_triangle(a, c, {x, line(i), line(j + 1)});
    }
  Random random(68);
  std::vector<Ray> rays;
  for (int run = 0; run < 4000; ++run) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(1, static_cast<double>(random.uniform(-0.2f, 0.2f)),
                                                           static_cast<double>(random.uniform(-0.2f, 0.2f))));
    const double far = static_cast<double>(random.uniform(1, 200));
    const double z = static_cast<double>(line(1 + static_cast<int>(random.below(cells - 1))));
    const double y = static_cast<double>(random.uniform(-3.5f, 3.5f));
    const glm::dvec3 from = glm::dvec3(static_cast<double>(x), y, z) - far * direction;
    for (int i = 0; i < 16; ++i)
      rays.push_back(make_ray(glm::vec3(from + glm::dvec3(0, 0.002 * i, 0)), glm::vec3(direction)));
  }
  const Bvh single = tracer.make(soup, BvhTraversal::scalar), wide = tracer.make(soup, BvhTraversal::wide_16),
            portable = tracer.make(soup, BvhTraversal::wide_16_portable),
            eight = tracer.make(soup, BvhTraversal::wide_8);
  CHECK(count_hits(tracer.trace(single, rays)) == rays.size());
  check_packets(tracer, single, {&wide, &portable, &eight}, rays);
}

TEST_CASE("neighbouring rays decide about veils by themselves, in packets too") {
  SceneMaterial veil;
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color.a = 0.5f;
  Scene scene = moving_bodies();
  scene.animations.clear();
  scene.materials[0] = veil;
  Tracer tracer;
  const SceneBuffers buffers(tracer.device(), scene);
  std::vector<Ray> rays = camera_rays(160, 100, 25);
  for (uint32_t i = 0; i < rays.size(); ++i) rays[i].origin.w = std::bit_cast<float>(2 * i + 1);
  CHECK(count_packets(rays, 25) == rays.size() / 16);
  const Bvh single(tracer.device(), scene, buffers, BvhTraversal::scalar),
      wide(tracer.device(), scene, buffers, BvhTraversal::wide_16),
      portable(tracer.device(), scene, buffers, BvhTraversal::wide_16_portable),
      eight(tracer.device(), scene, buffers, BvhTraversal::wide_8);
  check_packets(tracer, single, {&wide, &portable, &eight}, rays);
}

TEST_CASE("a ray that begins far to the side of its run changes nothing for the others") {
  Tracer tracer;
  Soup soup;  // of triangles smaller than the grid of coordinates that far away
  Random random(64);
  for (int i = 0; i < 30000; ++i) {
    const glm::vec3 middle = random.in_cube(10);
    soup.add_triangle(middle + random.in_cube(0.3f), middle + random.in_cube(0.3f), middle + random.in_cube(0.3f));
  }
  const Bvh single = tracer.make(soup, BvhTraversal::scalar), wide = tracer.make(soup, BvhTraversal::wide_16),
            portable = tracer.make(soup, BvhTraversal::wide_16_portable),
            eight = tracer.make(soup, BvhTraversal::wide_8);
  for (const float aside : {1e3f, 1e5f, 1e7f}) {
    // Of one direction each and nearly across the offset, where nothing but the margin makes up for coarse coordinates.
    std::vector<Ray> rays = parallel_runs(4000, 10, 0.04f, 65);
    for (Ray& ray : rays)
      ray.direction = float4(glm::normalize(glm::vec3(0.01f, 1, 1) * ray.direction.xyz()), INFINITY);
    for (size_t run = 0; run < rays.size(); run += 16) {
      rays[run].origin.x = run % 32 ? aside : -aside;
      if (run % 3 == 0) rays[run + 7].origin.x = rays[run + 15].origin.x = rays[run].origin.x;
    }
    check_packets(tracer, single, {&wide, &portable, &eight}, rays);
  }
}

TEST_CASE("packets find their way through the top of several hierarchies") {
  Tracer tracer;
  const Scene scene = moving_bodies();
  const SceneBuffers buffers(tracer.device(), scene);
  const Bvh single(tracer.device(), buffers.scene_vertices.download(), buffers.scene_triangles.download(),
                   BvhTraversal::scalar);
  const Bvh wide(tracer.device(), scene, buffers, BvhTraversal::wide_16),
      portable(tracer.device(), scene, buffers, BvhTraversal::wide_16_portable),
      eight(tracer.device(), scene, buffers, BvhTraversal::wide_8),
      scalar(tracer.device(), scene, buffers, BvhTraversal::scalar);
  CHECK(single.statistics().parts == 1);
  CHECK(wide.statistics().parts == 21);
  check_packets(tracer, single, {&wide, &portable, &eight, &scalar}, camera_rays(320, 200, 25));
}

TEST_CASE("rays of pixels are traced in tiles of 4 by 4, each of them once") {
  const std::vector<uint32_t> order = traced_order(12, 12 * 8);
  constexpr uint32_t second[16] = {4, 5, 6, 7, 16, 17, 18, 19, 28, 29, 30, 31, 40, 41, 42, 43};
  for (uint32_t i = 0; i < 16; ++i) CHECK(order[16 + i] == second[i]);
  CHECK(order[48] == 48);  // the next band
  // Two rows behind the last whole band.
  const std::vector<uint32_t> with_rest = traced_order(12, 12 * 6);
  CHECK(with_rest[16] == 4);
  for (uint32_t i = 48; i < 12 * 6; ++i) CHECK(with_rest[i] == i);
  const std::pair<uint32_t, uint32_t> sizes[] = {{12, 96}, {12, 72}, {320, 320 * 180}, {4, 16}};
  for (const auto& [row, count] : sizes) {
    CAPTURE(row);
    std::vector<uint32_t> sorted = traced_order(row, count);
    std::sort(sorted.begin(), sorted.end());
    for (uint32_t i = 0; i < count; ++i) REQUIRE(sorted[i] == i);
  }
}

TEST_CASE("rays that are no whole rows, or too few, are traced as they lie") {
  const std::pair<uint32_t, uint32_t> sizes[] = {{0, 64}, {10, 80}, {12, 94}, {16, 32}};
  for (const auto& [row, count] : sizes) {
    CAPTURE(row);
    CAPTURE(count);
    const std::vector<uint32_t> order = traced_order(row, count);
    for (uint32_t i = 0; i < count; ++i) REQUIRE(order[i] == i);
  }
}

TEST_CASE("in tiles as in rows every pixel gets its own hit") {
  Tracer tracer;
  const Soup soup = rough_sphere(60, 80, 9);
  const Bvh single = tracer.make(soup, BvhTraversal::scalar);
  const std::pair<uint32_t, uint32_t> sizes[] = {{160, 104}, {158, 100}, {160, 99}, {36, 8}};
  for (const auto& [width, height] : sizes) {
    CAPTURE(width);
    std::vector<Ray> rays = camera_rays(width, height, 2.5f);
    // A corner that looks elsewhere, whose tiles are no packets.
    for (uint32_t i = 0; i < rays.size(); ++i)
      if (i % width < 20 && i / width < 6) rays[i] = random_rays(1, i).front();
    const auto count = static_cast<uint32_t>(rays.size());
    const Results expected = tracer.trace(single, rays);
    CHECK(count_hits(expected) > rays.size() / 20);
    for (const BvhTraversal traversal : traversals) {
      const Results found = tracer.trace(tracer.make(soup, traversal), rays, count, count, width);
      CHECK(std::memcmp(found.hits.data(), expected.hits.data(), rays.size() * sizeof(Hit)) == 0);
    }
  }
  // In a narrow picture runs in rows cross from one side to the other, squares do not.
  const std::vector<Ray> narrow = camera_rays(24, 24, 25);
  CHECK(count_packets(narrow, 25, 24) == 36);
  CHECK(count_packets(narrow, 25) < 36);
}

TEST_CASE("rays of pixels behind the last one that is there stay untouched") {
  Tracer tracer;
  const Soup soup = rough_sphere(20, 30, 9);
  const std::vector<Ray> rays = camera_rays(32, 16, 2.5f);
  const Results all = tracer.trace(tracer.make(soup, BvhTraversal::scalar), rays);
  for (const BvhTraversal traversal : traversals) {
    const Bvh bvh = tracer.make(soup, traversal);
    for (const uint32_t count : {32u * 8, 32u * 9, 32u * 8 + 5}) {
      CAPTURE(count);
      const Results found = tracer.trace(bvh, rays, count, 32 * 16, 32);
      CHECK(std::memcmp(found.hits.data(), all.hits.data(), count * sizeof(Hit)) == 0);
      for (uint32_t i = count; i < rays.size(); ++i) REQUIRE(found.hits[i].triangle == 0xeeeeeeeeu);
    }
  }
}
