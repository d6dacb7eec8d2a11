// SPDX-License-Identifier: Apache-2.0
// Look-ups of rays in a stored bundle, eight at once, have the bits of look-ups one by one.
#include <cstring>
#include <random>

#include "bidirectional_rig.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/shared/ray.h"

const lucarium::EmbeddedSources& test_bidirectional_vpl_kernels();
const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A sphere about two boxes, and `tiny`: about one that is too small for what is computed of eight normals at once.
Scene boxes_in_sphere(bool tiny) {
  Scene scene = sphere_room(0.5f, glm::vec3(0, 1.5f, 0));
  const int grey = add_material(scene, lambert(0.5f));
  add_box(scene, glm::vec3(-0.9f, -0.7f, -0.6f), glm::vec3(-0.2f, 0.4f, 0.3f), false, grey);
  add_box(scene, glm::vec3(0.1f, -0.3f, -0.2f), glm::vec3(0.8f, 0.1f, 0.7f), false, grey);
  if (tiny) add_box(scene, glm::vec3(0), glm::vec3(5e-8f), false, grey);
  return scene;
}

struct LookUps {
  std::vector<Ray> rays;
  std::vector<uint32_t> left, order;
};

/// From random points of triangles, half of them of the boxes behind all others, both ways along a direction.
LookUps random_look_ups(const SceneBuffers& buffers, uint32_t of_boxes, const glm::vec3& along, uint32_t count) {
  const std::vector<Triangle> triangles = buffers.scene_triangles.download();
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  const uint32_t all = buffers.info().triangle_count;
  const auto corner = [&](uint32_t v) {
    return glm::vec3(vertices[v].position.x, vertices[v].position.y, vertices[v].position.z);
  };
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0, 1);
  LookUps look_ups;
  for (uint32_t i = 0; i < count; ++i) {
    const auto number = static_cast<uint32_t>(random());
    const uint32_t triangle = number % 2 ? number / 2 % all : all - 1 - number / 2 % of_boxes;
    const Triangle& t = triangles[triangle];
    const float u = unit(random), v = (1 - u) * unit(random);
    const glm::vec3 p = (1 - u - v) * corner(t.v0) + u * corner(t.v1) + v * corner(t.v2);
    Ray ray{};
    ray.origin = float4(p, 0);
    ray.direction = float4(random() % 2 ? along : -along, 1e30f);
    look_ups.rays.push_back(ray);
    look_ups.left.push_back(triangle);
    look_ups.order.push_back(i);
  }
  std::shuffle(look_ups.order.begin(), look_ups.order.end(), random);
  return look_ups;
}

/// Looks up the same rays eight at once and one by one.
void compare_look_ups(bool tiny) {
  constexpr uint32_t kCount = 20'003, kSide = 96;
  const Scene scene = boxes_in_sphere(tiny);
  Device& device = *test_device();
  KernelScheduler scheduler(test_device());
  const SceneBuffers buffers(device, scene);
  const LayeredRaster raster(scheduler, buffers, {.max_width = kSide, .max_height = kSide}, "test");
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(test_bidirectional_vpl_kernels());
  const Program program(
      device, library,
      {"test_bidirectional_vpl/look_ups", {"test_bidirectional_vpl/look_ups.cl"}, {{"LUCARIUM_JOINED", "1"}}});
  const glm::vec3 along = glm::normalize(glm::vec3(0.4f, -0.7f, 0.5f)),
                  right = glm::normalize(glm::cross(along, glm::vec3(0, 1, 0)));
  // Some points lie beside the view.
  const TypedBuffer<LayeredView> views(
      device, "test", "views",
      std::vector{orthographic_view(glm::vec3(0), along, right, 0.04f, kSide, kSide, 2.1f, glm::vec2(-1.9f))});
  const LookUps look_ups = random_look_ups(buffers, tiny ? 36 : 24, along, kCount);
  const TypedBuffer<Ray> rays(device, "test", "rays", look_ups.rays);
  const TypedBuffer<uint32_t> left(device, "test", "left", look_ups.left),
      order(device, "test", "order", look_ups.order),
      starts(device, "test", "starts", std::vector<uint32_t>{0, kCount});
  const TypedBuffer<Hit> eight(device, "test", "hits", kCount), one(device, "test", "hits one by one", kCount);
  ScheduleRecorder recorder = scheduler.record("look up", "test");
  const LayeredRaster::Stored stored = raster.record_stored(recorder, "layers", {views, recorder.variable("view", 0u)});
  const auto pass = [&](const char* kernel, uint32_t items, const TypedBuffer<Hit>& hits) {
    PassBuilder builder = recorder.pass(kernel, program, kernel);
    buffers.bind(builder);
    return builder.global(items)
        .arg("views", views)
        .arg("pixel_start", stored.pixel_start)
        .arg("fragments", stored.fragments)
        .arg("rays", rays)
        .arg("left", left)
        .arg("hits", hits);
  };
  pass("look_up_bundle", kCount / 50 + 1, eight)
      .slice(1 << 16)
      .arg("number", 0u)
      .arg("chunk", 50u)
      .arg("start_base", 0u)
      .arg("fragment_base", 0u)
      .arg("starts", starts)
      .arg("order", order);
  pass("look_up_one", kCount, one).arg("count", kCount);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  const std::vector<Hit> found = eight.download(), expected = one.download();
  size_t different = 0, seen = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    different += std::memcmp(&found[i], &expected[i], sizeof(Hit)) != 0;
    seen += expected[i].triangle != LUCARIUM_NO_HIT;
  }
  CHECK(different == 0);
  CHECK(seen > kCount / 4);
  CHECK(seen < kCount * 3 / 4);
}

}  // namespace

TEST_CASE("stored bundles: eight look-ups at once have the bits of look-ups one by one") { compare_look_ups(false); }

TEST_CASE("stored bundles: where one of eight look-ups needs care, all have the bits of look-ups one by one") {
  compare_look_ups(true);
}
