// SPDX-License-Identifier: Apache-2.0
// Frames: after motions, builds for every frame, and cancelled passes the bits are those of a fresh start.
#include <doctest/doctest.h>

#include "lucarium/scene/builtin/scenes.h"
#include "technique_picture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

Scene solids_at(double time, int animation) {
  Scene scene = make_builtin_scene("solids");
  evaluate(scene, time, animation);
  return scene;
}

struct Run {
  explicit Run(const Scene& scene, Parameters more = {}) {
    more.emplace_back("abuffer_size", "256");
    session = test::session(scene, {.size = 20, .max_bounces = 1}, more);
  }
  std::vector<float> iterate(int iterations) {
    for (int i = 0; i < iterations; ++i) session->iterate();
    std::vector<float> all;
    const Film film = session->resolve();
    for (const FilmLayer& layer : film.layers()) all.insert(all.end(), layer.pixels.begin(), layer.pixels.end());
    return all;
  }
  std::unique_ptr<RenderSession> session;
};

Parameters with(Parameters some, const Parameters& more) {
  some.insert(some.end(), more.begin(), more.end());
  return some;
}

}  // namespace

TEST_CASE("frames: one of an animation has the bits of a fresh start there") {
  for (const int animation : {0, 1})  // rigid, morph
    for (const Parameters& how :
         {Parameters{{"mode", "path"}}, Parameters{{"mode", "ao"}, {"intersect", "auto"}, {"search", "3"}},
          Parameters{{"mode", "whitted"}, {"intersect", "auto"}, {"static_set", "on"}}}) {
      CAPTURE(animation);
      CAPTURE(how.back().first);
      Run followed(solids_at(0, animation), how);
      const std::vector<float> before = followed.iterate(1);
      for (const double time : {0.4, 1.3}) followed.session->set_time(time);
      const std::vector<float> found = followed.iterate(1);
      CHECK(found != before);
      CHECK(found == Run(solids_at(1.3, animation), how).iterate(1));
    }
}

TEST_CASE("frames: rebuild=frame has the bits of rebuild=change, and builds once per frame") {
  for (const char* structure : {"abuffer", "octree"}) {
    CAPTURE(std::string(structure));
    const Parameters general = {{"structure", structure}, {"progressive", "off"}, {"passes", "1"}};
    Run change(solids_at(0, 0), general), frame(solids_at(0, 0), with(general, {{"rebuild", "frame"}}));
    const auto builds = [](Run& run) { return run.session->technique().counters().at("builds"); };
    CHECK(change.iterate(3) == frame.iterate(3));
    CHECK(builds(change) == 1);
    CHECK(builds(frame) == 3);
    for (Run* run : {&change, &frame}) run->session->set_time(0.8);
    CHECK(change.iterate(2) == frame.iterate(2));
    CHECK(builds(change) == 2);
    CHECK(builds(frame) == 5);
    SceneCamera camera = change.session->scene().cameras.front();
    camera.world_from_camera[3].x += 0.1f;
    for (Run* run : {&change, &frame}) run->session->set_camera(camera);
    CHECK(change.iterate(1) == frame.iterate(1));
    CHECK(builds(change) == 2);  // a camera builds nothing
  }
}

TEST_CASE("frames: what was cancelled, at any moment, leaves no trace") {
  for (const char* mode : {"path", "whitted", "ao"}) {
    CAPTURE(std::string(mode));
    // Every iteration is a frame, which builds.
    const Parameters how = {
        {"mode", mode}, {"progressive", "off"}, {"passes", "1"}, {"rebuild", "frame"}, {"intersect", "auto"}};
    Run undisturbed(solids_at(0, 0), how), halted(solids_at(0, 0), how);
    RenderSession& session = *halted.session;
    const std::vector<float> first = undisturbed.iterate(1);
    uint32_t cancelled = 0;
    for (int after = 0; after < 12; ++after) {
      int requests = after;
      session.scheduler().set_cancel([&] { return requests-- <= 0; });
      const uint64_t before = session.iterations();
      session.iterate();
      cancelled += session.iterations() == before;
    }
    CHECK(cancelled > 3);
    session.scheduler().set_cancel([] { return false; });
    CHECK(halted.iterate(1) == first);
    // A motion, cancelled from its first moment on.
    session.scheduler().set_cancel([] { return true; });
    session.set_time(0.6);
    session.iterate();
    session.scheduler().set_cancel([] { return false; });
    undisturbed.session->set_time(0.6);
    CHECK(halted.iterate(1) == undisturbed.iterate(1));
  }
}
