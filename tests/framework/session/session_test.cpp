// SPDX-License-Identifier: Apache-2.0
// A render session around the technique `constant`, whose image is known exactly.
#include "lucarium/session/session.h"

#include <doctest/doctest.h>

#include <cstdlib>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/processor_time.h"
#include "lucarium/compute/program/program.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/session/counted_seconds.h"
#include "lucarium/session/memory_needs.h"

using namespace lucarium;

namespace {

using Parameters = std::vector<std::pair<std::string, std::string>>;

const TechniqueType& constant_type() {
  static const TechniqueRegistry registry({std::filesystem::path(std::getenv("LUCARIUM_TEST_PLUGINS")) / "constant"});
  return registry.find("constant");
}

RenderSettings small_settings() {
  RenderSettings settings;
  settings.width = 7;
  settings.height = 5;
  settings.max_bounces = 1;
  return settings;
}

RenderSession make_session(const Parameters& parameters = {}, RenderSettings settings = small_settings()) {
  Scene scene = load_scene("builtin:cornell");
  settings.camera = scene.cameras.front();
  return RenderSession(test::test_device(), std::move(scene), constant_type(), settings, parameters);
}

struct Failure {
  ErrorClass error_class = ErrorClass::internal;
  std::string message = "nothing was thrown";
};

template <class Action>
Failure failure_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return {error.error_class(), error.what()};
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("budgets end a run, and the film has the image, the layers and where they come from") {
  RenderSession session = make_session({{"red", "0.75"}});
  CHECK(session.limitations() == std::vector<std::string>{"the scene is ignored"});
  CHECK_FALSE(session.run({.iterations = 3}));
  CHECK(session.iterations() == 3);
  CHECK_FALSE(session.run({.samples = 5}));
  CHECK(session.last().samples == 5);
  CHECK_FALSE(session.run({.iterations = 2}));
  CHECK(session.last().samples == 7);
  const Film film = session.resolve();
  const std::vector<float> image = film.image();
  for (size_t p = 0; p < film.pixel_count(); ++p) {
    CHECK(image[3 * p] == 0.75f);
    CHECK(image[3 * p + 1] == 0.5f);
    CHECK(image[3 * p + 2] == 1.f);
  }
  REQUIRE(film.find("count"));
  CHECK(film.find("count")->pixels[34] == 7);
  CHECK(film.metadata.at("technique") == "constant");
  CHECK(contains(film.metadata.at("parameters"), "red=0.75,green=0.5"));
  CHECK(film.metadata.at("samples") == "7");
  CHECK(film.metadata.at("admitted_bias") == "0");
  CHECK(PathSet::parse(film.metadata.at("path_set")).max_bounces == 1);
  CHECK(film.metadata.at("scene_hash") == session.scene().hash().hex());
}

TEST_CASE("a time budget ends a run, and so do convergence and the user") {
  RenderSession timed = make_session({{"sleep", "5"}});
  CHECK_FALSE(timed.run({.seconds = 0.02}));
  CHECK(timed.iterations() >= 1);
  CHECK(timed.iterations() <= 4);
  CHECK(timed.clocks().iterate >= 0.02);

  RenderSession converging = make_session({{"converge_at", "4"}});
  CHECK_FALSE(converging.run({}));
  CHECK(converging.iterations() == 4);

  RenderSession interrupted = make_session();
  set_interrupt_requested(true);
  CHECK(interrupted.run({.iterations = 3}));
  set_interrupt_requested(false);
  CHECK(interrupted.iterations() == 0);
}

TEST_CASE("processor time is that of what is counted: not of sleep, not of kernels that are compiled") {
  {
    RenderSession sleeping = make_session({{"sleep", "50"}});
    const RenderSession::Clocks prepared = sleeping.clocks();
    CHECK(prepared.prepare_processor > 0);
    CHECK(prepared.iterate_processor == 0);
    const double before = processor_seconds();
    CHECK_FALSE(sleeping.run({.iterations = 4}));
    const RenderSession::Clocks done = sleeping.clocks();
    CHECK(done.iterate >= 0.2);
    CHECK(done.iterate_processor > 0);
    CHECK(done.iterate_processor <= processor_seconds() - before);
    CHECK(done.iterate_processor < 0.5 * done.iterate);
    CHECK(done.prepare_processor == prepared.prepare_processor);
    CHECK(counted_processor_seconds(done) == done.prepare_processor + done.iterate_processor);
  }
  test::test_device()->kept_programs().clear();  // the next session has to make them again
  const double programs = program_processor_seconds(), start = processor_seconds();
  const RenderSession compiling = make_session();
  REQUIRE(program_processor_seconds() > programs + 1e-3);  // reading one takes longer
  CHECK(compiling.clocks().prepare_processor <=
        processor_seconds() - start - (program_processor_seconds() - programs) + 1e-9);
}

TEST_CASE("what a technique does not declare is refused before anything is allocated") {
  RenderSettings deep = small_settings(), grid = small_settings(), huge = small_settings();
  deep.max_bounces = -1;
  grid.pixel_sampling = 4;
  huge.width = huge.height = 32768;
  const Failure bounces = failure_of([&] { make_session({}, deep); });
  CHECK(bounces.error_class == ErrorClass::technique);
  CHECK(contains(bounces.message, "at most 3 bounces; give --max-bounces 3"));
  CHECK(failure_of([&] { make_session({}, grid); }).error_class == ErrorClass::technique);
  CHECK(failure_of([&] { make_session({}, huge); }).error_class == ErrorClass::usage);
  const Failure unknown = failure_of([&] { make_session({{"rde", "1"}}); });
  CHECK(unknown.error_class == ErrorClass::usage);
  CHECK(unknown.message == "constant: no parameter is called 'rde'; did you mean 'red'?");
  const Failure memory = failure_of([&] { make_session({{"extra_megabytes", "100000000"}}); });
  CHECK(memory.error_class == ErrorClass::device);
  CHECK(contains(memory.message, "TiB"));
}

TEST_CASE("only Error leaves a technique, and no NaN leaves a session") {
  for (const char* kind : {"error", "exception", "nan"}) {
    RenderSession session = make_session({{"failure", kind}, {"fail_at", "2"}});
    session.iterate();
    const Failure failure = failure_of([&] {
      session.iterate();
      session.resolve();
    });
    CAPTURE(failure.message);
    CHECK(failure.error_class == ErrorClass::technique);
    CHECK(failure.message.starts_with("constant: "));
    if (std::string(kind) == "nan")
      CHECK(contains(failure.message, "1 values are NaN and 0 infinite, the first in layer direct at pixel (1, 1)"));
  }
  RenderSession negative = make_session({{"failure", "negative"}, {"fail_at", "1"}});
  negative.iterate();
  CHECK(negative.resolve().count_bad_pixels().negative == 1);
}

TEST_CASE("another size of the image is refused where the technique does not declare that it follows") {
  RenderSession session = make_session();
  const Failure failure = failure_of([&] { session.set_view(session.settings().camera, 3, 2, false); });
  CHECK(failure.error_class == ErrorClass::technique);
  CHECK(failure.message == "constant: its image keeps its size; make another session");
  CHECK(session.settings().width == 7);
}

TEST_CASE("a change of the scene starts over; one that the technique cannot follow is refused") {
  RenderSession session = make_session();
  session.run({.iterations = 3});
  session.set_camera(session.settings().camera);
  CHECK(session.iterations() == 0);
  CHECK(session.clocks().iterate == 0);
  session.run({.iterations = 2});
  CHECK(session.resolve().find("count")->pixels[0] == 2);
  session.set_time(1.0);  // nothing moves, but a frame of a sequence stands for itself
  session.run({.iterations = 2});
  CHECK(session.resolve().find("count")->pixels[0] == 2);
  CHECK(session.resolve().metadata.at("scene_time_seconds") == "1");
}

TEST_CASE("surfaces that become MASK in a running session let rays through") {
  static const TechniqueRegistry registry({std::filesystem::path(std::getenv("LUCARIUM_TEST_PLUGINS")) / "faulty"});
  const auto render = [](RenderSession& session) {
    session.run({.iterations = 2});
    return session.resolve().image();
  };
  const auto open_session = [](const Scene& scene) {
    RenderSettings settings = small_settings();
    settings.camera = scene.cameras.front();
    return RenderSession(Device::open(), scene, registry.find("faulty"), settings, {});
  };
  const auto hide_all = [](Scene& scene) {
    SceneChange change;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
      if (scene.materials[i].emits()) continue;
      scene.materials[i].alpha_mode = AlphaMode::mask;
      scene.materials[i].base_color.a = 0;
      change.materials.push_back(static_cast<int>(i));
    }
    return change;
  };
  const Scene opaque = load_scene("builtin:cornell");
  Scene hidden = opaque;
  hide_all(hidden);
  RenderSession changed = open_session(opaque), fresh = open_session(hidden);
  const std::vector<float> before = render(changed), expected = render(fresh);
  CHECK(before != expected);
  changed.change_scene(hide_all);
  CHECK(render(changed) == expected);
}

TEST_CASE("all buffers together may exceed the limit for one, and only what is used is counted") {
  const std::filesystem::path plugins = std::getenv("LUCARIUM_TEST_PLUGINS");
  static const TechniqueRegistry registry({plugins / "faulty", plugins / "constant"});
  const Scene scene = load_scene("builtin:cornell");
  RenderSettings settings = small_settings();
  settings.width = settings.height = 128;
  settings.camera = scene.cameras.front();
  const auto needed = [&](const char* name) {
    const std::unique_ptr<Technique> technique = registry.find(name).create();
    return needed_bytes(registry.find(name).info(), *technique, scene, settings);
  };
  const auto run = [&](const char* name, size_t total, size_t single) {
    DeviceOptions options;
    options.memory_limit_bytes = total;
    options.allocation_limit_bytes = single;
    RenderSession session(Device::open(options), scene, registry.find(name), settings, {});
    session.run({.iterations = 1});
  };
  const size_t traced = needed("faulty"), constant = needed("constant");
  CHECK_NOTHROW(run("faulty", 2 * traced, traced / 2));
  CHECK(contains(failure_of([&] { run("faulty", traced - 1, traced - 1); }).message,
                 "all buffers of scene, BVH and technique"));
  const std::unique_ptr<Technique> technique = registry.find("constant").create();
  CHECK(constant == SceneBuffers::estimate_bytes(scene) + technique->estimate_bytes(scene, settings));
}

TEST_CASE("a cancelled iteration is not counted") {
  RenderSession session = make_session();
  session.run({.iterations = 2});
  session.scheduler().set_cancel([] { return true; });
  session.iterate();
  CHECK(session.iterations() == 2);
  CHECK(session.resolve().metadata.at("iterations") == "2");
  session.scheduler().set_cancel([] { return false; });
  session.iterate();
  CHECK(session.iterations() == 3);
}

TEST_CASE("a change that is refused leaves scene, settings and picture as they were") {
  Scene scene = load_scene("builtin:cornell");
  scene.nodes.emplace_back();
  scene.instances.front().node = scene.cameras.front().node = static_cast<int>(scene.nodes.size()) - 1;
  const float keys[] = {0, 0, 0, 2, 0, 0};
  scene.animations = {{"shift",
                       {{scene.instances.front().node,
                         AnimationPath::translation,
                         Interpolation::linear,
                         {0, 2},
                         {std::begin(keys), std::end(keys)}}},
                       2}};
  evaluate(scene, 0.5);
  RenderSettings settings = small_settings();
  settings.camera = scene.cameras.front();
  RenderSession session(test::test_device(), scene, constant_type(), settings);
  session.run({.iterations = 3});
  const auto check_unchanged = [&](const std::string& kind, const std::function<void()>& change) {
    const Failure failure = failure_of(change);
    CHECK(failure.error_class == ErrorClass::technique);
    CHECK(contains(failure.message, "constant: cannot follow a change of " + kind));
    CHECK(session.scene().hash() == scene.hash());
    CHECK(session.scene().time == 0.5);
    CHECK(session.scene().cameras.front().world_from_camera == scene.cameras.front().world_from_camera);
    CHECK(session.settings().camera.world_from_camera == settings.camera.world_from_camera);
    CHECK(session.iterations() == 3);
    CHECK(session.resolve().find("count")->pixels[0] == 3);
  };
  check_unchanged("transforms", [&] { session.set_time(1); });
  check_unchanged("materials", [&] {
    session.change_scene([](Scene& edited) {
      edited.cameras.front().world_from_camera[3].x += 1;
      edited.materials.front().roughness = 0.5f;
      SceneChange change;
      change.camera = true;
      change.materials = {0};
      return change;
    });
  });
  CHECK_THROWS_WITH_AS(session.change_scene([](Scene& edited) -> SceneChange {
    edited.meshes.clear();
    throw std::runtime_error("half an edit");
  }),
                       "constant: half an edit", Error);
  CHECK(session.scene().hash() == scene.hash());
}
