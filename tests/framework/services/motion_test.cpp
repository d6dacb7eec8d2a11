// SPDX-License-Identifier: Apache-2.0
// Services that are kept while the scene moves: the same bits as those of new ones, and nothing compiled or allocated.
#include "lucarium/film/film.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kMotionSide = 24;

/// A box below a lamp; both move.
Scene moving_lamp() {
  Scene scene;
  scene.source = "test:moving lamp";
  const int white = add_lambert(scene, "white", glm::vec3(0.7f)), lamp = add_emitter(scene, "lamp", glm::vec3(4));
  add_instance(scene, add_mesh(scene, MeshBuilder("floor").box({-3, -1, -3}, {3, 0, 3}).take()), white);
  add_instance(scene, add_mesh(scene, MeshBuilder("box").box({-0.3f, 0, -0.3f}, {0.3f, 0.6f, 0.3f}).take()), white);
  add_instance(scene, add_mesh(scene, MeshBuilder("lamp").box({-0.2f, 2, -0.2f}, {0.2f, 2.1f, 0.2f}).take()), lamp);
  test::add_light(scene, LightType::point, 3, {1, 2, 1}, {0, 0, 0});
  set_environment(scene, 0.2f);
  scene.cameras.push_back(look_at_camera("front", {0, 1, 4}, {0, 0.3f, 0}, 40));
  return scene;
}

/// The lamp grows and moves, so that its share of the light samples changes; the point light goes out at the end.
SceneChange move(Scene& scene, double seconds) {
  SceneChange change;
  for (const int i : {1, 2}) {
    change.moved_instances.push_back(i);
    change.previous_world_from_object.push_back(scene.instances[i].world_from_object);
    scene.instances[i].world_from_object =
        glm::translate(glm::mat4(1), glm::vec3(0.3 * seconds * i, 0, -0.1 * seconds)) *
        glm::scale(glm::mat4(1), glm::vec3(static_cast<float>(1 + 0.5 * seconds)));
  }
  if (seconds > 1.5) {
    scene.lights[0].intensity = glm::vec3(0);
    change.lights = true;
  }
  return change;
}

/// What the services of one scene compute.
struct Pictures {
  std::vector<float> layers;
  std::vector<float4> direct;
  bool operator==(const Pictures& other) const {
    const auto bytes = [](const std::vector<float4>& v) { return v.size() * sizeof(float4); };
    return layers == other.layers && bytes(direct) == bytes(other.direct) &&
           std::memcmp(direct.data(), other.direct.data(), bytes(direct)) == 0;
  }
};

struct MotionRig {
  MotionRig(const Scene& scene, const PathIntegratorOptions& options)
      : render(scene, scene.cameras.at(0), options, kMotionSide),
        gbuffer(*test_device(), render.scheduler, render.buffers, render.bvh, render.frame, "test"),
        direct(*test_device(), render.scheduler, render.buffers, render.bvh, "test"),
        sums(*test_device(), "test", "sums", kMotionSide * kMotionSide) {}

  void follow(const Scene& scene, const SceneChange& change) {
    render.buffers.update(scene, change);
    render.bvh.update(scene, render.buffers, change);
    render.integrator->follow_scene();
  }
  Pictures pictures() {
    REQUIRE(render.integrator->iterate());
    sums.fill_zero();
    REQUIRE(gbuffer.render(0));
    REQUIRE(direct.accumulate_radiance(gbuffer.points(), sums, 0, 5));
    render.scheduler.finish();
    Film film(kMotionSide, kMotionSide);
    render.integrator->resolve(film);
    Pictures result;
    for (const char* layer : {"emission", "direct", "indirect"})
      result.layers.insert(result.layers.end(), film.find(layer)->pixels.begin(), film.find(layer)->pixels.end());
    result.direct = sums.download();
    return result;
  }
  TestRender render;
  GBuffer gbuffer;
  DirectLight direct;
  TypedBuffer<float4> sums;
};

/// Follows the scene through `times`, and compares with a fresh start at each.
template <class Pose>
void check_motion(const Scene& scene, const PathIntegratorOptions& options, const std::vector<double>& times,
                  Pose pose) {
  Scene kept = scene;
  pose(kept, 0);
  MotionRig rig(kept, options);
  Pictures before = rig.pictures();
  const uint64_t scene_generation = rig.render.buffers.generation(), bvh_generation = rig.render.bvh.generation();
  for (const double seconds : times) {
    CAPTURE(seconds);
    const uint64_t allocations = test_device()->memory().allocations();
    const double program_seconds = test_device()->program_seconds();
    rig.follow(kept, pose(kept, seconds));
    REQUIRE(rig.render.buffers.generation() == scene_generation);
    REQUIRE(rig.render.bvh.generation() == bvh_generation);
    const Pictures followed = rig.pictures();
    CHECK(test_device()->memory().allocations() == allocations);
    CHECK(test_device()->program_seconds() == program_seconds);
    CHECK(!(followed == before));
    Scene fresh = scene;
    pose(fresh, seconds);
    CHECK(followed == MotionRig(fresh, options).pictures());
    before = followed;
  }
}

}  // namespace

TEST_CASE("motion: services follow rigid motion and morphs as new ones would begin") {
  const Scene scene = make_builtin_scene("solids");
  for (const int animation : {0, 1}) {
    CAPTURE(animation);
    check_motion(scene, limited(2), {0.7, 1.9, 0.7},
                 [&](Scene& s, double seconds) { return evaluate(s, seconds, animation); });
  }
}

TEST_CASE("motion: a lamp that moves and grows, and a light that goes out, with light tables of path sets") {
  for (const char* left_out : {"none", "environment", "lamps"}) {
    CAPTURE(left_out);
    PathIntegratorOptions options = limited(1);
    options.path_set.environment = left_out != std::string("environment");
    options.path_set.emissive_triangles = left_out != std::string("lamps");
    check_motion(moving_lamp(), options, {0.5, 1, 2}, move);
  }
}

TEST_CASE("motion: shadow rays begin when a first light appears") {
  Scene scene = moving_lamp();
  scene.environment.reset();
  PathIntegratorOptions options = limited(1);
  options.path_set.emissive_triangles = false;
  const auto pose = [](Scene& s, double seconds) {
    s.lights[0].intensity = glm::vec3(static_cast<float>(seconds));
    SceneChange change;
    change.lights = true;
    return change;
  };
  Scene dark = scene;
  pose(dark, 0);
  MotionRig rig(dark, options);
  rig.pictures();
  rig.follow(dark, pose(dark, 1));
  Scene fresh = scene;
  pose(fresh, 1);
  CHECK(rig.pictures() == MotionRig(fresh, options).pictures());
}
