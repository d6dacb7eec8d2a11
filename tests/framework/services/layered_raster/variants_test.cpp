// SPDX-License-Identifier: Apache-2.0
// All ways to the fragments of a pixel agree, to the bit; k-buffers keep the nearest and count the rest.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "lucarium/base/error.h"
#include "scene.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::string layer_bytes(const HostLayers& layers) {
  std::string bytes(reinterpret_cast<const char*>(layers.pixel_start.data()), 4 * layers.pixel_start.size());
  bytes.append(reinterpret_cast<const char*>(layers.fragments.data()),
               sizeof(LayeredFragment) * layers.fragments.size());
  return bytes;
}

constexpr uint32_t width = 90, height = 70;

}  // namespace

TEST_CASE("variants") {
  // The second set has pixels with far more than 64 fragments.
  for (const uint32_t count : {200u, 3000u}) {
    CAPTURE(count);
    const LayeredView view = pixel_view(width, height);
    LayeredScene scene(scene_of(image_triangles(count, width, height, count)),
                       {.max_width = width, .max_height = height});
    const HostLayers tiles = scene.store(view);
    CHECK(tiles.fragments.size() > 10000);
    CHECK(same_layers(scene.store(view, {.variant = LayeredVariant::exact}), tiles));
    CHECK(same_layers(scene.store(view, {.variant = LayeredVariant::linked_list, .list_capacity = 1000}), tiles));
    // Grows: one node per pixel never suffices.
    CHECK(same_layers(scene.store(view, {.variant = LayeredVariant::linked_list, .list_capacity = 1}), tiles));

    LayeredScene few(scene_of(image_triangles(count, width, height, count)),
                     {.max_width = width, .max_height = height, .row_layers = 4});
    CHECK(same_layers(few.store(view), tiles));

    for (const uint32_t keep : {1u, 3u, 64u}) {
      CAPTURE(keep);
      const HostLayers kept = scene.store(view, {.variant = LayeredVariant::k_buffer, .keep = keep});
      uint32_t wrong = 0, dropped = 0;
      for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
          const auto all = tiles.at(x, y), some = kept.at(x, y);
          const size_t expected = std::min<size_t>(keep, all.size());
          wrong +=
              some.size() != expected || std::memcmp(some.data(), all.data(), expected * sizeof(LayeredFragment)) != 0;
          dropped += static_cast<uint32_t>(all.size() - expected);
        }
      CHECK(wrong == 0);
      CHECK(kept.dropped == dropped);
    }

    const LayeredScene::Nearest nearest = scene.nearest(view);
    uint32_t wrong = 0;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const auto all = tiles.at(x, y);
        const uint32_t triangle = all.empty() ? LUCARIUM_NONE : all[0].triangle;
        const float depth = all.empty() ? INFINITY : all[0].depth;
        wrong += nearest.triangle[y * width + x] != triangle || nearest.depth[y * width + x] != depth;
      }
    CHECK(wrong == 0);
  }
}

TEST_CASE("without compiler built-ins") {
  const LayeredView view = pixel_view(width, height);
  const Scene triangles = scene_of(image_triangles(3000, width, height, 2));
  LayeredScene native(triangles, {.max_width = width, .max_height = height});
  LayeredScene portable(triangles, {.max_width = width, .max_height = height, .portable = true});
  CHECK(same_layers(native.store(view), portable.store(view)));
}

TEST_CASE("no pass reads what none has written or writes outside its memory") {
  Soup soup = image_triangles(300, width, height, 5);
  soup.add_triangle({-1e5f, -2e5f, 0}, {3e5f, 10, 1}, {-1e5f, 2e5f, 2});  // is clipped
  const LayeredView view = pixel_view(width, height);
  LayeredScene plain(scene_of(soup), {.max_width = width, .max_height = height});
  LayeredScene guarded(scene_of(soup), {.max_width = width, .max_height = height}, {}, {.debug_memory = true});
  for (const LayeredVariant variant :
       {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list, LayeredVariant::k_buffer}) {
    const LayeredStoreOptions options{.variant = variant, .list_capacity = 2};
    CHECK(same_layers(plain.store(view, options), guarded.store(view, options)));
  }
}

TEST_CASE("where memory does not suffice, the refusal says what the owner of the raster would lower") {
  const LayeredView view = pixel_view(width, height);
  const Scene triangles = scene_of(image_triangles(3000, width, height, 2));
  const auto refusal = [&](const LayeredStoreOptions& store) -> std::string {
    try {
      LayeredScene scene(triangles, {.max_width = width, .max_height = height, .remedy = "lower the test's size"},
                         {.memory_limit_bytes = 2 << 20});
      scene.store(view, store);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  for (const LayeredVariant variant : {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list})
    CHECK(refusal({.variant = variant}).find("lower the test's size") != std::string::npos);
}

TEST_CASE("moved triangles, and others") {
  const LayeredView view = pixel_view(width, height);
  const auto moved_by = [](float x, uint32_t count) {
    Scene scene = scene_of(image_triangles(count, width, height, 12));
    scene.instances[0].world_from_object[3].x = x;
    return scene;
  };
  LayeredScene scene(moved_by(0, 300), {.max_width = width, .max_height = height});
  const HostLayers before = scene.store(view);
  SceneChange change;
  change.moved_instances = {0};
  change.previous_world_from_object = {glm::mat4(1)};
  scene.update(moved_by(16, 300), change);
  LayeredScene fresh(moved_by(16, 300), {.max_width = width, .max_height = height});
  const HostLayers after = scene.store(view);
  CHECK_FALSE(same_layers(after, before));
  CHECK(same_layers(after, fresh.store(view)));
  const uint64_t generation = scene.raster().generation();
  change = {};
  change.topology = true;
  scene.update(moved_by(0, 500), change);
  LayeredScene other(moved_by(0, 500), {.max_width = width, .max_height = height});
  CHECK(scene.raster().generation() > generation);
  CHECK(same_layers(scene.store(view), other.store(view)));
}

namespace {

void add_square(Soup& soup, bool away, float depth) {
  const glm::vec3 a(2, 2, depth), b(14, 2, depth), c(14, 14, depth), d(2, 14, depth);
  soup.add_triangle(a, away ? b : d, c);
  soup.add_triangle(a, away ? c : b, away ? d : c);
  if (!away) std::swap(soup.triangles.back().v1, soup.triangles.back().v2);
}

}  // namespace

TEST_CASE("equal depths: fronts along the view first, then by triangle") {
  // The same square four times: seen from behind, from the front, from behind, and one a little nearer than a tie.
  Soup soup;
  add_square(soup, false, 1);
  add_square(soup, true, 1);
  add_square(soup, false, 1);
  add_square(soup, true, 1 - 1e-4f);
  LayeredScene scene(scene_of(soup), {.max_width = 16, .max_height = 16});
  for (const LayeredVariant variant : {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list}) {
    const HostLayers layers = scene.store(pixel_view(16, 16), {.variant = variant});
    uint32_t wrong = 0;
    for (uint32_t y = 2; y < 14; ++y)
      for (uint32_t x = 2; x < 14; ++x) {
        const auto pixel = layers.at(x, y);
        REQUIRE(pixel.size() == 4);
        const auto square_of = [](const LayeredFragment& f) { return (f.triangle & ~LAYERED_AWAY) / 2; };
        const uint32_t order[4] = {square_of(pixel[0]), square_of(pixel[1]), square_of(pixel[2]), square_of(pixel[3])};
        wrong += order[0] != 3 || order[1] != 1 || order[2] != 0 || order[3] != 2;
      }
    CHECK(wrong == 0);
  }
}

TEST_CASE("nearly equal depths: fronts along the view first, wherever a step of depth ends") {
  // Rounding has put the square that is seen from behind in front by less than a step, 32 / 2^22 here.
  const float step = 32 / 4194304.0f, gap = 0.9f * step;
  for (int i = 0; i < 8; ++i) {
    Soup soup;
    const float depth = 3 + static_cast<float>(i) / 8 * step;
    add_square(soup, false, depth);
    add_square(soup, true, depth + gap);
    add_square(soup, false, depth + gap + 3 * step);
    LayeredScene scene(scene_of(soup), {.max_width = 16, .max_height = 16});
    for (const LayeredVariant variant : {LayeredVariant::tiles, LayeredVariant::exact, LayeredVariant::linked_list}) {
      const HostLayers layers = scene.store(pixel_view(16, 16), {.variant = variant});
      uint32_t wrong = 0;
      for (uint32_t y = 2; y < 14; ++y)
        for (uint32_t x = 2; x < 14; ++x) {
          const auto pixel = layers.at(x, y);
          REQUIRE(pixel.size() == 3);
          wrong += !(pixel[0].triangle & LAYERED_AWAY) || pixel[1].triangle & LAYERED_AWAY ||
                   !(pixel[1].depth < pixel[0].depth);
        }
      CHECK(wrong == 0);
    }
  }
}

// Run by the next test in processes of their own, since drivers choose their threads once per process.
TEST_CASE("layers for a number of threads" * doctest::skip(std::getenv("LUCARIUM_TEST_LAYERS") == nullptr)) {
  DeviceOptions device;
  device.threads = std::atoi(std::getenv("LUCARIUM_TEST_THREADS"));
  LayeredScene scene(scene_of(image_triangles(3000, 300, 300, 9)), {.max_width = 300, .max_height = 300}, device);
  std::ofstream(std::getenv("LUCARIUM_TEST_LAYERS"), std::ios::binary)
      << layer_bytes(scene.store(pixel_view(300, 300)));
}

TEST_CASE("one and two threads give the same bits") {
  TemporaryFolder folder;
  std::string found[2];
  for (int threads : {1, 2}) {
    const std::string file = (folder.path() / std::to_string(threads)).string();
    const ProgramResult result =
        run_program("LUCARIUM_TEST_THREADS=" + std::to_string(threads) + " LUCARIUM_TEST_LAYERS=" + file + " /proc/" +
                    std::to_string(getpid()) + "/exe --test-case='layers for a number of threads'");
    REQUIRE(result.exit_code == 0);
    std::ifstream in(file, std::ios::binary);
    found[threads - 1].assign(std::istreambuf_iterator<char>(in), {});
  }
  CHECK(found[0].size() > 1000000);
  CHECK(found[0] == found[1]);
}

TEST_CASE("refusals") {
  Soup soup;
  soup.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK_THROWS_AS(LayeredScene(scene_of(soup), {.max_width = 0}), Error);
  CHECK_THROWS_AS(LayeredScene(scene_of(soup), {.max_width = 5000}), Error);
  LayeredScene scene(scene_of(soup), {.max_width = 8, .max_height = 8});
  CHECK_THROWS_AS(scene.store(pixel_view(8, 8), {.variant = LayeredVariant::k_buffer, .keep = 65}), Error);
}
