// SPDX-License-Identifier: Apache-2.0
// Scenes and eyes that are out of the ordinary, and what is refused.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "closed_bodies.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "made_scene.h"
#include "technique_picture.h"
#include "test_support.h"
#include "tolerance.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;

namespace {

/// Rays that hit where others miss, or the other way round.
uint32_t missed_or_invented(const AbufferRig::Results& a, const AbufferRig::Results& b) {
  uint32_t count = 0;
  for (size_t i = 0; i < a.hits.size(); ++i)
    count += (a.hits[i].triangle == LUCARIUM_NO_HIT) != (b.hits[i].triangle == LUCARIUM_NO_HIT);
  return count;
}

}  // namespace

TEST_CASE("extremes: parity hits tiny, huge and far bodies where it hits ordinary ones") {
  struct Place {
    const char* name;
    float scale;
    glm::vec3 offset;
  };
  uint32_t ordinary_far = 0;
  for (const Place& place : {Place{"1 m", 1, {}}, Place{"1e-3 m", 1e-3f, {}}, Place{"1e3 m", 1e3f, {}},
                             Place{"1 km off", 1, {1000, 0, 0}}}) {
    CAPTURE(std::string(place.name));
    AbufferRig rig(scene_of(placed(closed_bodies(), place.scale, place.offset)));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const VoxelAbuffer structure = rig.make({.abuffer_size = 640});
    CHECK(structure.statistics().unbalanced_columns == 0);
    CHECK(structure.statistics().exact_triangles == 0);
    const TestRays rays = scene_rays(rig, 15000, 5);
    const AbufferRig::Results right = rig.trace(bvh, rays.rays), found = rig.trace(structure, rays.rays, rays.ends);
    uint32_t far = 0, hits = 0;
    for (size_t i = 0; i < rays.rays.size(); ++i) {
      if (right.hits[i].triangle == LUCARIUM_NO_HIT || found.hits[i].triangle == LUCARIUM_NO_HIT) continue;
      ++hits;
      far += std::fabs(right.hits[i].distance - found.hits[i].distance) > 4 * structure.state().grid.center.w;
    }
    CHECK(hits > 5000);
    CHECK(missed_or_invented(right, found) <= 30);  // 0.2 %
    CHECK(far <= 50);                               // backs may err more often
    if (ordinary_far == 0) ordinary_far = far;
    CHECK(far <= 2 * ordinary_far);
  }
}

TEST_CASE("extremes: a single triangle is hit where the hierarchy hits it, with every search") {
  Soup soup;
  soup.add_triangle({0, 0, 0}, {1, 0, 0.3f}, {0.2f, 1, 0.1f});
  AbufferRig rig(scene_of(soup));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const std::vector<Ray> rays = scene_rays(rig, 6000, 5).rays;
  const AbufferRig::Results right = rig.trace(bvh, rays);
  for (const Intersect intersect : {Intersect::exact, Intersect::automatic})
    CHECK(differences(right, rig.trace(rig.make({.intersect = intersect}), rays)) == 0);
  uint32_t hits = 0;
  for (const Hit& hit : right.hits) hits += hit.triangle != LUCARIUM_NO_HIT;
  CHECK(hits > 200);
}

TEST_CASE(
    "extremes: degenerate triangles and vertices that are no numbers harm nothing else; infinite ones are refused") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  Soup soup = closed_bodies();
  const size_t good = soup.triangles.size();
  soup.add_triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  soup.add_triangle({0, 0, 0}, {1, 1, 1}, {2, 2, 2});
  soup.add_triangle({0, 0, 0}, {1e-30f, 0, 0}, {0, 1e-30f, 0});
  const AbufferRig whole(scene_of(soup));
  const TestRays rays = scene_rays(whole, 9000, 5);
  for (const bool numbers : {true, false}) {
    CAPTURE(numbers);
    Scene scene = whole.scene;
    if (!numbers) scene.meshes[0].positions.back() = scene.meshes[0].positions[4003] = {nan, 0, nan};
    AbufferRig rig(scene);
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const AbufferRig::Results right = rig.trace(bvh, rays.rays);
    CHECK(differences(right, rig.trace(rig.make({.abuffer_size = 400, .intersect = Intersect::exact}), rays.rays)) ==
          0);
    const VoxelAbuffer automatic = rig.make({.abuffer_size = 400});
    CHECK(automatic.statistics().parity_triangles + automatic.statistics().exact_triangles == good + 3);
    CHECK(missed_or_invented(right, rig.trace(automatic, rays.rays, rays.ends)) <= rays.rays.size() / 500);
  }
  Scene endless = whole.scene;
  endless.meshes[0].positions.back() = {0, infinity, 0};
  AbufferRig rig(endless);
  CHECK_THROWS_WITH_AS(rig.make(), doctest::Contains("positions that are infinite"), Error);
}

TEST_CASE("extremes: ten thousand layers in a column") {
  Soup sheets, slabs;
  for (Soup* soup : {&sheets, &slabs}) append(*soup, box({-3, -3, -3}, {-2.9f, 3, 3}));  // so that pixels are large
  for (int i = 0; i < 10000; ++i) {
    const float z = 1e-4f * static_cast<float>(i);
    sheets.add_triangle({-0.3f, -0.3f, z}, {0.3f, -0.3f, z}, {0, 0.3f, z});
  }
  for (int i = 0; i < 5000; ++i) {
    const float z = 2e-4f * static_cast<float>(i);
    append(slabs, box({-0.1f, -0.1f, z}, {0.1f, 0.1f, z + 1e-4f}));
  }
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 to(random.uniform(-0.08f, 0.08f), random.uniform(-0.08f, 0.05f), i % 2 ? 1.f : 0.f);
    const glm::vec3 from(to.x + random.uniform(-0.1f, 0.1f), to.y + random.uniform(-0.1f, 0.1f), i % 2 ? 3.f : -2.f);
    rays.push_back(make_ray(from, glm::normalize(to - from)));
  }
  AbufferRig open(scene_of(sheets)), closed(scene_of(slabs));
  const VoxelAbuffer exact = open.make({.abuffer_size = 128, .intersect = Intersect::exact, .count_work = true});
  CHECK(exact.statistics().longest_list >= 10000);
  const Bvh bvh(open.scheduler.device(), open.scene, open.buffers);
  CHECK(differences(open.trace(bvh, rays), open.trace(exact, rays)) == 0);
  const VoxelAbuffer parity = closed.make({.abuffer_size = 128, .intersect = Intersect::parity, .count_work = true});
  CHECK(parity.statistics().longest_list >= 10000);
  CHECK(parity.statistics().exact_triangles == 0);
  const AbufferRig::Results found = closed.trace(parity, rays);
  uint32_t wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Ray& ray = rays[i];
    const float z = ray.origin.z + found.hits[i].distance * ray.direction.z;  // within a pixel of the outermost
    wrong += found.hits[i].triangle == LUCARIUM_NO_HIT || !found.occluded[i] ||
             std::fabs(z - (i % 2 ? 1.f : 0.f)) > parity.state().grid.center.w;
  }
  CHECK(wrong == 0);
}

TEST_CASE("extremes: an eye inside a solid, inside two, and in a room") {
  Soup room = box({-4, -4, -4}, {4, 4, 4});
  for (Triangle& t : room.triangles) std::swap(t.v1, t.v2);  // fronts inside
  append(room, sphere({}, 1));
  append(room, box({0.2f, -0.4f, -0.4f}, {3, 0.4f, 0.4f}));
  AbufferRig rig(scene_of(room));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  for (const Search search : {Search::columns, Search::three_steps, Search::one_step}) {
    CAPTURE(static_cast<int>(search));
    const VoxelAbuffer structure = rig.make({.search = search});
    CHECK(structure.statistics().exact_triangles == 0);
    for (const glm::vec3& eye :
         {glm::vec3(-0.4f, 0.1f, 0.2f), glm::vec3(0.6f, 0.1f, 0.1f), glm::vec3(2, 0, 0.1f), glm::vec3(-2, 1, 1)}) {
      CAPTURE(eye.x);
      Random random(4);
      std::vector<Ray> rays;
      for (int i = 0; i < 4000; ++i) rays.push_back(make_ray(eye, random.direction()));
      const AbufferRig::Results right = rig.trace(bvh, rays), found = rig.trace(structure, rays);
      uint32_t far = 0;
      for (size_t i = 0; i < rays.size(); ++i)
        far += found.hits[i].triangle != LUCARIUM_NO_HIT &&
               std::fabs(right.hits[i].distance - found.hits[i].distance) > 4 * structure.state().grid.center.w;
      CHECK(missed_or_invented(right, found) == 0);
      MESSAGE(far, " of ", rays.size(), " more than four pixels off");
      if (search == Search::columns) CHECK(far <= 24);  // 0.6 %
    }
  }
}

TEST_CASE("extremes: an eye inside glass sees as over the hierarchy, with exact search and with parity") {
  Scene scene;
  SceneMaterial glass = clear_glass();
  test::add_triangles(scene, sphere_triangles({0, 1, 0}, 1, 5, false), add_material(scene, glass));
  test::add_horizontal(scene, 0, -0.5f, 0, 9, 9, true, add_material(scene, lambert(0.5f)));
  set_environment(scene, 1);
  scene.cameras.push_back(look_perspective({0.1f, 1.2f, 0.3f}, {0.3f, 0, 0}, 0.7f));
  for (const char* mode : {"path", "whitted"}) {
    const auto picture = [&](const char* structure, const char* intersect) {
      const Film film =
          render(scene, {.max_bounces = 2}, {{"mode", mode}, {"structure", structure}, {"intersect", intersect}});
      std::vector<float> all;
      for (const FilmLayer& layer : film.layers()) all.insert(all.end(), layer.pixels.begin(), layer.pixels.end());
      return all;
    };
    const std::vector<float> right = picture("bvh", "exact");
    CHECK(picture("abuffer", "exact") == right);
    double sum = 0, parity = 0;
    for (const float value : right) sum += static_cast<double>(value);
    for (const float value : picture("abuffer", "auto")) parity += static_cast<double>(value);
    CHECK(sum > 0);
    CHECK(parity == test::relative(sum, 0.02));
  }
}

TEST_CASE("extremes: values out of range are refused in one line with the parameter and the value") {
  const Scene scene = make_builtin_scene("cornell");
  const auto refused = [&](const char* parameter, const char* value, const std::string& text) {
    CAPTURE(std::string(parameter));
    try {
      render(scene, {}, {{parameter, value}});
      FAIL("not refused");
    } catch (const Error& error) {
      const std::string message = error.what();
      CHECK(message.find(text) != std::string::npos);
      CHECK(message.find('\n') == std::string::npos);
    }
  };
  refused("abuffer_size", "100", "parameter abuffer_size: 100 is outside 128");
  refused("abuffer_size", "5000", "parameter abuffer_size: 5000 is outside 128");
  refused("grid_size", "3000", "parameter grid_size: 3000 is outside 0");
  refused("bisect", "3", "parameter bisect: 3 is outside 4");
  refused("offset_h", "0.2", "parameter offset_h: 0.2 is outside 0.5");
  refused("depth", "17", "parameter depth: 17 is outside 1");
  refused("lambda", "65", "parameter lambda: 65 is outside 1");
  refused("passes", "-1", "parameter passes: -1 is outside 0");
  refused("ambient", "-1", "parameter ambient: -1 is outside 0");
  refused("intersect", "guess", "parameter intersect: no value is called 'guess'");
}

TEST_CASE("extremes: buffers beyond memory are refused before they are made, with parameter and value") {
  const Scene scene = make_builtin_scene("cornell");
  const Picture picture = {.max_bounces = 2, .device = {.memory_limit_bytes = size_t{300} << 20}};
  const auto refused = [&](const Parameters& parameters, const char* named) {
    CHECK_THROWS_WITH_AS(render(scene, picture, parameters), doctest::Contains(named), Error);
  };
  refused({{"abuffer_size", "4096"}}, "abuffer_size (4096)");
  refused({{"abuffer_size", "2048"}, {"grid_size", "2048"}}, "grid_size (2048)");
  refused({{"abuffer_size", "4096"}, {"structure", "octree"}}, "abuffer_size (4096)");
  CHECK_NOTHROW(render(scene, picture, {{"abuffer_size", "256"}}));
}

TEST_CASE("extremes: open components under intersect=parity are a limitation, with their number") {
  const auto limitations = [&](const Scene& scene, const char* intersect) {
    RenderSettings settings;
    settings.camera = scene.cameras.front();
    const std::unique_ptr<Technique> technique = registry().find("voxel_abuffer").create();
    technique->parameters().set("intersect", intersect);
    std::string all;
    for (const std::string& line : technique->limitations(scene, settings)) all += line + "\n";
    return all;
  };
  const Scene cornell = make_builtin_scene("cornell");
  CHECK(limitations(cornell, "parity").find("intersect=parity: 6 open components") != std::string::npos);
  CHECK(limitations(cornell, "auto").find("open components") == std::string::npos);
  CHECK(limitations(make_builtin_scene("solids"), "parity").find("open components") == std::string::npos);
}

TEST_CASE("extremes: parameters that others leave without effect are named, and no others") {
  const Scene scene = make_builtin_scene("solids");
  const auto idle = [&](const Parameters& parameters) {
    RenderSettings settings;
    settings.camera = scene.cameras.front();
    const std::unique_ptr<Technique> technique = registry().find("voxel_abuffer").create();
    for (const auto& [name, value] : parameters) technique->parameters().set(name, value);
    std::string all;
    for (const std::string& line : technique->limitations(scene, settings))
      if (line.find(" no effect: ") != std::string::npos) all += line + "\n";
    return all;
  };
  CHECK(idle({}).empty());
  CHECK(idle({{"preset", "paper"}, {"bisect", "8"}, {"static_set", "on"}}).empty());
  CHECK(idle({{"intersect", "plane"}, {"attributes", "pixel"}, {"axis_rule", "average"}}).empty());
  CHECK(idle({{"structure", "grid"}, {"grid_size", "64"}, {"mode", "ao"}, {"ao_radius", "2"}}).empty());
  CHECK(idle({{"mode", "whitted"}, {"depth", "5"}, {"ambient", "1"}}).empty());
  CHECK(idle({{"search", "3"}}) == "search has no effect: no hit is found by parity (intersect)\n");
  CHECK(idle({{"intersect", "auto"}, {"bisect", "8"}}) == "bisect has no effect: all columns are visited (search)\n");
  CHECK(idle({{"attributes", "stored"}, {"axis_rule", "average"}}) ==
        "axis_rule, attributes have no effect: no hit is found by parity or planes (intersect)\n");
  CHECK(idle({{"structure", "octree"}, {"intersect", "parity"}, {"search", "1"}}) ==
        "intersect, search have no effect: there are no A-buffers (structure)\n");
  CHECK(idle({{"structure", "bvh"}, {"abuffer_size", "256"}}) ==
        "abuffer_size has no effect: the hierarchy has no pixels (structure)\n");
  CHECK(idle({{"ambient", "1"}, {"ao_radius", "2"}}) ==
        "ambient has no effect: it belongs to mode=whitted\nao_radius has no effect: it belongs to mode=ao\n");
}
