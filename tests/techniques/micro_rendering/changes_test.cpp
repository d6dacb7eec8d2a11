// SPDX-License-Identifier: Apache-2.0
// What a change of the scene costs: passes are counted.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "technique_fixture.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

enum class Motion { shift, stretch, appear };

/// The room, whose box hangs on a node that an animation moves, stretches, or scales from nothing to its size.
Scene room_with_moving_box(Motion motion) {
  Scene scene = load_scene("builtin:room");
  if (motion == Motion::shift) animate_last_instance(scene, AnimationPath::translation, {0, 0, 0, 0.1f, 0, 0.1f});
  if (motion == Motion::stretch) animate_last_instance(scene, AnimationPath::scale, {1, 1.1f, 1, 1.1f, 1.3f, 1});
  if (motion == Motion::appear) animate_last_instance(scene, AnimationPath::scale, {0, 0, 0, 1, 1, 1});
  return scene;
}

class CountedSession {
 public:
  CountedSession(Scene scene, int max_bounces)
      : settings_(settings_for(scene, 24, max_bounces)),
        session_(Device::open(), std::move(scene), registry().find("micro_rendering"), settings_, small) {
    session_.run({.iterations = 1});
  }
  RenderSession& session() { return session_; }
  /// How often passes of that name ran since the last call of forget().
  uint64_t count(const std::string& name) {
    session_.scheduler().finish();
    uint64_t sum = 0;
    for (const PassProfile& pass : session_.scheduler().profile().passes) sum += pass.name == name ? pass.count : 0;
    return sum;
  }
  void forget() {
    session_.scheduler().finish();
    session_.scheduler().reset_profile();
  }

 private:
  RenderSettings settings_;
  RenderSession session_;
};

}  // namespace

TEST_CASE("pictures of a moving view are coarse, gather at few pixels, and lose nothing of points and light") {
  for (const Parameters& more : {Parameters{}, Parameters{{"node_shading", "dynamic"}, {"gather_env", "on"}},
                                 Parameters{{"cut_error", "0.1"}}, Parameters{{"gather_step", "2"}}}) {
    CAPTURE(more.empty() ? std::string("default") : more.front().first);
    const Scene scene = load_scene("builtin:room");
    const RenderSettings settings = settings_for(scene, 48, 2);
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings, with(small, more));
    session.run({.iterations = 1});
    const double sampled = session.technique().counters().at("sampling seconds");
    SceneCamera camera = settings.camera;
    camera.world_from_camera[3].x -= 0.1f;
    RenderSettings moved = settings;
    moved.camera = camera;
    RenderSession alone(Device::open(), scene, registry().find("micro_rendering"), moved, with(small, more));
    alone.run({.iterations = 1});
    const double gathers = session.technique().counters().at("gathers");
    for (const uint32_t size : {24u, 24u, 15u}) {
      session.set_view(camera, size, size, true);
      session.run({.iterations = 2});
      CHECK(session.last().samples == 2);  // whatever frame the light at the points is of
      const Film film = session.resolve();
      CHECK(film.width() == size);
      CHECK((film.find("upsampling_failed") != nullptr) == (more.size() == 1 && more.front().first == "gather_step"));
      RenderSettings coarse = moved;
      coarse.width = coarse.height = size;
      RenderSession all(Device::open(), scene, registry().find("micro_rendering"), coarse, with(small, more));
      all.run({.iterations = 2});
      const double share = mean(film.find("indirect")->pixels) / mean(all.resolve().find("indirect")->pixels);
      CAPTURE(size);
      CHECK(share > 0.9);
      CHECK(share < 1.1);
    }
    CHECK(session.technique().counters().at("gathers") < gathers + 6 * 6 * 6 + 1);
    CHECK(session.technique().counters().at("sampling seconds") == sampled);  // no points were placed again
    session.set_view(camera, 48, 48, false);
    session.run({.iterations = 1});
    CHECK(session.resolve().find("indirect")->pixels == alone.resolve().find("indirect")->pixels);
    CHECK(session.resolve().find("direct")->pixels == alone.resolve().find("direct")->pixels);
  }
}

TEST_CASE("a view that moves before points have light shows direct light, and the light comes with rest") {
  const Scene scene = load_scene("builtin:room");
  const RenderSettings settings = settings_for(scene, 24, 2);
  RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings, small);
  session.set_view(settings.camera, 12, 12, true);
  session.run({.iterations = 2});
  const Film coarse = session.resolve();
  CHECK(mean(coarse.find("direct")->pixels) > 0);
  CHECK(mean(coarse.find("indirect")->pixels) == 0);
  session.set_view(settings.camera, 24, 24, false);
  session.run({.iterations = 1});
  CHECK(session.resolve().find("indirect")->pixels == indirect_light(scene, "micro_rendering", 24, 2, 1, small));
}

TEST_CASE("a camera that moves costs gathers alone") {
  CountedSession counted(load_scene("builtin:room"), 2);
  SceneCamera camera = counted.session().settings().camera;
  camera.world_from_camera[3].x -= 0.1f;
  counted.forget();
  counted.session().set_camera(camera);
  counted.session().run({.iterations = 1});
  for (const char* pass : {"update leaves", "refit", "albedo of leaves", "sample light at points", "gathers at nodes",
                           "gather at nodes", "pull"}) {
    CAPTURE(pass);
    CHECK(counted.count(pass) == 0);
  }
  CHECK(counted.count("gather") > 0);
  CHECK(counted.count("list gathers") > 0);
  // The picture is that of a fresh start.
  Scene scene = load_scene("builtin:room");
  scene.cameras.front() = camera;
  CountedSession fresh(std::move(scene), 2);
  CHECK(counted.session().resolve().image() == fresh.session().resolve().image());
}

TEST_CASE("light at points that takes long takes iterations of its own, and is the same light") {
  const Parameters by_paths = with(small, {{"multibounce", "instant_radiosity"}, {"vpls", "20"}});
  for (const Parameters& parameters : {small, by_paths}) {
    CAPTURE(parameters.size());
    const Scene scene = load_scene("builtin:room");
    const auto iterations = [&](const char* batch, std::vector<float>& image) {
      RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings_for(scene, 8, 3),
                            with(parameters, {{"batch_gathers", batch}}));
      bool waited = false;
      session.run({.samples = 1}, [&](const IterationResult& now) {
        waited = waited || (now.samples == 0 && now.phase == "light");
        return true;
      });
      CHECK(waited == (session.iterations() > 1));
      image = session.resolve().find("indirect")->pixels;
      return session.iterations();
    };
    std::vector<float> at_once, by_and_by;
    CHECK(iterations("16384", at_once) == 1);
    CHECK(iterations("64", by_and_by) >= 2);
    CHECK(at_once == by_and_by);
  }
}

TEST_CASE("lights that change cost light and gathers, and no geometry") {
  CountedSession counted(load_scene("builtin:room"), 2);
  counted.forget();
  counted.session().change_scene([](Scene& scene) {
    scene.lights.front().intensity *= 2.f;
    SceneChange change;
    change.lights = true;
    return change;
  });
  counted.session().run({.iterations = 1});
  for (const char* pass : {"update leaves", "refit", "albedo of leaves", "gathers at nodes"}) {
    CAPTURE(pass);
    CHECK(counted.count(pass) == 0);
  }
  for (const char* pass : {"sample light at points", "gather at nodes", "pull", "gather"}) {
    CAPTURE(pass);
    CHECK(counted.count(pass) > 0);
  }
}

TEST_CASE("other colours cost light and gathers; another sidedness places the points again") {
  for (const bool sides : {false, true}) {
    CAPTURE(sides);
    const auto change = [&](Scene& scene) {
      SceneMaterial& material = scene.materials[static_cast<size_t>(scene.instances.back().material)];
      if (sides)
        material.double_sided = !material.double_sided;
      else
        material.base_color = glm::vec4(0.2f, 0.5f, 0.3f, 1);
      SceneChange done;
      done.materials.push_back(scene.instances.back().material);
      return done;
    };
    CountedSession counted(load_scene("builtin:room"), 2);
    counted.forget();
    counted.session().change_scene(change);
    counted.session().run({.iterations = 1});
    CHECK(counted.count("albedo of leaves") == 1);
    CHECK((counted.count("update leaves") > 0) == sides);
    Scene scene = load_scene("builtin:room");
    change(scene);
    CountedSession fresh(std::move(scene), 2);
    CHECK(counted.session().resolve().image() == fresh.session().resolve().image());
  }
}

TEST_CASE("a rigid object's motion refits nothing; a deformation refits its own tree alone") {
  for (const bool stretched : {false, true}) {
    CAPTURE(stretched);
    CountedSession counted(room_with_moving_box(stretched ? Motion::stretch : Motion::shift), 2);
    CHECK(counted.session().technique().counters().at("trees") == 2);
    counted.forget();
    counted.session().set_time(0.7);
    counted.session().run({.iterations = 1});
    CHECK(counted.count("update leaves") == (stretched ? 1 : 0));
    CHECK((counted.count("refit") > 0) == stretched);
    CHECK(counted.count("albedo of leaves") == 0);
    CHECK(counted.count("sample light at points") > 0);
    CHECK(counted.count("gather at nodes") > 0);
  }
}

TEST_CASE("what grows from nothing gets the points of its size, as in a fresh start") {
  CountedSession counted(room_with_moving_box(Motion::appear), 1);
  const double points_before = counted.session().technique().counters().at("points");
  counted.session().set_time(0.999);
  counted.session().run({.iterations = 1});
  Scene grown = room_with_moving_box(Motion::appear);
  evaluate(grown, 0.999);
  CountedSession fresh(std::move(grown), 1);
  CHECK(counted.session().technique().counters().at("points") > points_before);
  CHECK(counted.session().resolve().image() == fresh.session().resolve().image());
}

TEST_CASE("a moving thing of which nothing is covered costs nothing") {
  Scene scene = room_with_moving_box(Motion::shift);
  SceneMaterial unseen;
  unseen.alpha_mode = AlphaMode::blend;
  unseen.base_color.a = 0;
  scene.instances.back().material = static_cast<int>(scene.materials.size());
  scene.materials.push_back(unseen);
  CountedSession counted(std::move(scene), 1);
  CHECK(counted.session().technique().counters().at("trees") == 1);
  counted.forget();
  counted.session().set_time(0.7);
  counted.session().run({.iterations = 1});
  CHECK(counted.count("update leaves") == 0);
  CHECK(counted.count("albedo of leaves") == 0);
}

TEST_CASE("what a program moves again gets a tree of its own: its third motion refits nothing") {
  CountedSession counted(load_scene("builtin:room"), 1);
  CHECK(counted.session().technique().counters().at("trees") == 1);
  const auto move = [&] {
    counted.session().change_scene([](Scene& scene) {
      SceneChange change;
      change.moved_instances.push_back(0);
      scene.instances[0].world_from_object[3].x += 0.05f;
      return change;
    });
    counted.session().run({.iterations = 1});
  };
  move();
  // Once: the picture of a fresh start.
  CHECK(counted.session().technique().counters().at("trees") == 1);
  Scene moved = load_scene("builtin:room");
  moved.instances[0].world_from_object[3].x += 0.05f;
  CountedSession fresh(std::move(moved), 1);
  CHECK(counted.session().resolve().image() == fresh.session().resolve().image());
  move();
  CHECK(counted.session().technique().counters().at("trees") == 2);
  counted.forget();
  move();
  CHECK(counted.session().technique().counters().at("trees") == 2);
  CHECK(counted.count("update leaves") == 0);
  CHECK(counted.count("gather") > 0);
}

TEST_CASE("an animated character in a room: every frame is that of a fresh start, and only its tree is refitted") {
  if (shared_scenes().empty()) return skip("third-party scenes");
  const TemporaryFolder folder;
  const std::string room = (folder.path() / "room.glb").string(), both = (folder.path() / "both.glb").string();
  REQUIRE(run_program(lucarium_program() + " scene builtin:room --export " + room).exit_code == 0);
  const char* const source = std::getenv("LUCARIUM_TEST_SOURCE");
  if (!source) return skip("the source tree");
  const std::string merge = std::string("python3 ") + source + "/tools/merge_gltf.py ";
  if (run_program("python3 --version").exit_code != 0) return skip("python3");
  REQUIRE(run_program(merge + room + " " + (shared_scenes() / "animated/Fox.glb").string() + " " + both +
                      " --scale 0.009 --translate=-0.2,0,0.35 --turn 60")
              .exit_code == 0);
  Scene scene = load_scene(both);
  evaluate(scene, 0, 2);
  CountedSession counted(scene, 1);
  CHECK(counted.session().technique().counters().at("trees") == 2);
  counted.forget();
  counted.session().set_time(0.25);
  counted.session().run({.iterations = 1});
  CHECK(counted.count("update leaves") == 1);
  evaluate(scene, 0.25, scene.animation);
  CountedSession fresh(scene, 1);
  CHECK(counted.session().resolve().image() == fresh.session().resolve().image());
}

TEST_CASE("the first batch of the first frame is a picture that is worth keeping") {
  const Scene scene = load_scene("builtin:room");
  RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings_for(scene, 16, 1),
                        with(small, {{"batch_gathers", "64"}, {"light_samples", "1"}}));
  session.run({}, [](const IterationResult& now) { return !now.visible; });  // light fits into the first
  CHECK(session.last().samples == 0);
  const std::vector<float> coarse = session.resolve().find("indirect")->pixels;
  const auto iterations = session.iterations();
  session.run({.samples = 1});
  CHECK(session.iterations() == iterations + 3);  // sub-images of a quarter of the pixels
  const std::vector<float> whole = session.resolve().find("indirect")->pixels;
  CHECK(std::count(coarse.begin(), coarse.end(), 0.f) <= std::count(whole.begin(), whole.end(), 0.f) + 8);
  CHECK(std::abs(mean(coarse) - mean(whole)) < 0.2 * mean(whole));
}

TEST_CASE("counters go on where the points are placed again") {
  CountedSession counted(load_scene("builtin:room"), 1);
  const double before = counted.session().technique().counters().at("gathers");
  CHECK(before > 0);
  counted.session().change_scene([](Scene& scene) {
    scene.materials.front().double_sided = !scene.materials.front().double_sided;
    SceneChange change;
    change.materials = {0};
    return change;
  });
  CHECK(counted.session().technique().counters().at("gathers") == before);
  counted.session().run({.iterations = 1});
  CHECK(counted.session().technique().counters().at("gathers") == 2 * before);
}
