// SPDX-License-Identifier: Apache-2.0
// TechniqueBase over a technique that counts its calls, and fails on request.
#include "lucarium/technique/technique_base.h"

#include <doctest/doctest.h>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"

using namespace lucarium;

namespace {

struct BaseOptions {
  int value = 3;
  template <class V>
  void describe(V& v) {
    v.number("value", value, 0, 9, "", "of the test");
  }
};

class Counting : public TechniqueBase<BaseOptions> {
 public:
  PathSet path_set(const Scene&, const RenderSettings&) const override { return PathSet::no_light_transport(); }
  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override { return {}; }
  size_t estimate_bytes(const Scene&, const RenderSettings&) const override { return 0; }

  int compiled = 0, builds = 0, restarts = 0, followed = 0;
  bool cancels = false, builds_fail = false, is_interrupted = false, restarts_fail = false;
  uint32_t last_seed = 0;
  using TechniqueBase::built;
  using TechniqueBase::samples;

 protected:
  void compile() override { ++compiled; }
  void build() override {
    ++builds;
    if (is_interrupted) throw Error(ErrorClass::interrupted, "interrupted");
    if (builds_fail) throw Error(ErrorClass::device, "no memory");
  }
  bool follow(const SceneChange& change) override {
    ++followed;
    return TechniqueBase::follow(change);
  }
  void restart() override {
    ++restarts;
    if (restarts_fail) throw Error(ErrorClass::device, "no memory");
    last_seed = frame().seed;
  }
  bool step() override { return !cancels; }
  void write(Film& film) override { film.layer("counting", {"R", "G", "B"}, true); }
  void warm_up_kernels() override {}
};

struct Rig {
  Scene scene = make_builtin_scene("furnace");
  KernelScheduler scheduler{test::test_device()};
  SceneBuffers buffers{*test::test_device(), scene};
  RenderSettings settings;
  Counting technique;

  Rig() {
    settings.width = settings.height = 4;
    settings.seed = 7;
    settings.camera = scene.cameras.front();
    technique.prepare({test::test_device(), scheduler, scene, buffers, []() -> Bvh& { throw 0; }, settings,
                       [](double, const std::string&) {}});
  }
};

SceneChange camera_moved() {
  SceneChange change;
  change.camera = true;
  return change;
}

SceneChange lights_changed() {
  SceneChange change;
  change.lights = true;
  return change;
}

}  // namespace

TEST_CASE("a technique is compiled and built once, and samples that were cancelled are not counted") {
  Rig rig;
  Counting& t = rig.technique;
  CHECK((t.compiled == 1 && t.builds == 1 && t.restarts == 1 && t.last_seed == 7));
  CHECK(t.parameters().get("value") == "3");
  t.iterate();
  t.cancels = true;
  CHECK(t.iterate().samples == 1);
  t.cancels = false;
  CHECK(t.iterate().samples == 2);
  t.reset(11);
  CHECK((t.builds == 1 && t.restarts == 2 && t.last_seed == 11 && t.samples() == 0));
}

TEST_CASE("the camera alone restarts, other changes build, and nothing happens without a change") {
  Rig rig;
  Counting& t = rig.technique;
  t.iterate();
  t.update(camera_moved());
  CHECK((t.builds == 1 && t.restarts == 2 && t.samples() == 0));
  t.update(lights_changed());
  CHECK((t.builds == 2 && t.restarts == 3));
  t.update(SceneChange());
  CHECK((t.followed == 2 && t.restarts == 3));
}

TEST_CASE("an update that failed is made up for by the next call, and nothing can be shown before") {
  Rig rig;
  Counting& t = rig.technique;
  t.builds_fail = true;
  CHECK_THROWS_WITH_AS(t.update(lights_changed()), "no memory", Error);
  CHECK_FALSE(t.built());
  Film film(4, 4);
  CHECK_THROWS_WITH_AS(t.resolve(film), "the last change of the scene could not be applied; there is no image", Error);
  CHECK_THROWS_AS(t.iterate(), Error);
  t.builds_fail = false;
  SUBCASE("iterate") { CHECK(t.iterate().samples == 1); }
  SUBCASE("reset") { t.reset(5); }
  SUBCASE("warm-up") { t.warm_up(); }
  SUBCASE("another change, even of the camera alone") { t.update(camera_moved()); }
  CHECK(t.built());
  t.resolve(film);
  CHECK(film.find("counting"));
}

TEST_CASE("an interrupted update is left to the next iteration, and says so") {
  Rig rig;
  Counting& t = rig.technique;
  t.is_interrupted = true;
  t.update(lights_changed());
  CHECK_FALSE(t.built());
  Film film(4, 4);
  try {
    t.resolve(film);
    FAIL("there must be no image");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::interrupted);
  }
  t.is_interrupted = false;
  CHECK(t.iterate().samples == 1);
}

TEST_CASE("a second failure says what it was: not an interrupt any more, or one now") {
  Rig rig;
  Counting& t = rig.technique;
  const auto shown = [&] {
    Film film(4, 4);
    try {
      t.resolve(film);
    } catch (const Error& error) {
      return error.error_class();
    }
    return ErrorClass::internal;
  };
  t.is_interrupted = true;
  t.update(lights_changed());
  CHECK(shown() == ErrorClass::interrupted);
  t.is_interrupted = false, t.builds_fail = true;
  SUBCASE("iterate") { CHECK_THROWS_WITH_AS(t.iterate(), "no memory", Error); }
  SUBCASE("reset") { CHECK_THROWS_WITH_AS(t.reset(5), "no memory", Error); }
  SUBCASE("warm-up") { CHECK_THROWS_WITH_AS(t.warm_up(), "no memory", Error); }
  CHECK(shown() == ErrorClass::input);
  t.is_interrupted = true;
  CHECK_THROWS_WITH_AS(t.iterate(), "interrupted", Error);
  CHECK(shown() == ErrorClass::interrupted);
}

TEST_CASE("a technique that could not be restarted is rebuilt") {
  Rig rig;
  Counting& t = rig.technique;
  t.iterate();
  t.restarts_fail = true;
  CHECK_THROWS_WITH_AS(t.reset(5), "no memory", Error);
  CHECK_FALSE(t.built());
  Film film(4, 4);
  CHECK_THROWS_AS(t.resolve(film), Error);
  t.restarts_fail = false;
  CHECK(t.iterate().samples == 1);
  CHECK(t.builds == 2);
}
