// SPDX-License-Identifier: Apache-2.0
// Light at the points that is cancelled on its way: it goes on where it was, and nodes shine as before meanwhile.
#include <doctest/doctest.h>

#include <cstring>

#include "leaf_rig.h"
#include "lucarium/base/interrupt.h"
#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::micro;
using namespace lucarium::test;

namespace {

template <class T>
void append(std::vector<std::byte>& bytes, const TypedBuffer<T>& buffer) {
  if (!buffer) return;
  const std::vector<T> values = buffer.download();
  const size_t before = bytes.size();
  bytes.resize(before + values.size() * sizeof(T));
  std::memcpy(bytes.data() + before, values.data(), values.size() * sizeof(T));
}

/// All that gathers read of light.
std::vector<std::byte> shine(LeafRig& rig, const LeafLight& light) {
  rig.scheduler.finish();
  std::vector<std::byte> bytes;
  append(bytes, rig.forest.radiance);
  append(bytes, rig.forest.radiance_unit);
  append(bytes, light.shading().choices);
  append(bytes, light.shading().leaf_lights);
  return bytes;
}

constexpr int bounces = 3;
constexpr uint32_t seed = 7;

/// At most `limit` steps of a frame, every one of which is cancelled at its first request, then at its second, and so
/// on until it gets through.
struct Interrupted {
  int steps = 0, cancelled = 0;
  bool shone_alike = true;  ///< after every cancelled step as before it

  Interrupted(LeafRig& rig, LeafLight& light, uint32_t frame, int limit) {
    while (steps < limit) {
      const std::vector<std::byte> before = shine(rig, light);
      bool through = false;
      for (int allowed = 0; !through; ++allowed) {
        int requests = 0;
        rig.scheduler.set_cancel([&] { return requests++ >= allowed; });
        through = light.step(frame, seed);
        if (through) break;
        ++cancelled;
        shone_alike = shone_alike && shine(rig, light) == before;
      }
      ++steps;
    }
    rig.scheduler.set_cancel(interrupt_requested);
  }
};

MicroParameters parameters_of(MultiBounce multibounce, NodeShading shading) {
  MicroParameters parameters;
  parameters.points_log2 = 12;
  parameters.micro_size = 8;
  parameters.jacobi_level = 10;
  parameters.light_samples = 2;
  parameters.vpls = 3;
  parameters.photons = 1000;
  parameters.multibounce = multibounce;
  parameters.node_shading = shading;
  return parameters;
}

}  // namespace

TEST_CASE("light that is cancelled wherever it can be has the bits of undisturbed light, and repeats no step of it") {
  const Scene scene = load_scene("builtin:room");
  for (const NodeShading shading : {NodeShading::stored, NodeShading::dynamic})
    for (const MultiBounce multibounce : {MultiBounce::jacobi, MultiBounce::instant_radiosity}) {
      CAPTURE(static_cast<int>(shading));
      CAPTURE(static_cast<int>(multibounce));
      LeafRig calm(scene, parameters_of(multibounce, shading)), rig(scene, parameters_of(multibounce, shading));
      LeafLight expected = calm.light(bounces), light = rig.light(bounces);
      CHECK_FALSE(light.shines());
      for (uint32_t frame = 0; frame < 2; ++frame) {
        CAPTURE(frame);
        int steps = 0;
        for (; !expected.lit(frame, seed); ++steps) REQUIRE(expected.step(frame, seed));
        const Interrupted done(rig, light, frame, steps);
        CHECK(light.lit(frame, seed));
        CHECK(done.cancelled > steps);  // several times in every step that takes long
        CHECK(done.shone_alike);
        CHECK(light.shines());
        CHECK(light.gathers() == expected.gathers());
        CHECK(shine(rig, light) == shine(calm, expected));
      }
    }
}

TEST_CASE("light of photons that is cancelled has the bits of undisturbed light") {
  const Scene scene = load_scene("builtin:room");
  MicroParameters parameters = parameters_of(MultiBounce::photon_map, NodeShading::dynamic);
  parameters.points_log2 = 13;  // two slices, between which light has been added to some leaves
  LeafRig calm(scene, parameters), rig(scene, parameters);
  LeafLight expected = calm.light(bounces), light = rig.light(bounces);
  REQUIRE(expected.receive(0, seed));
  REQUIRE(expected.spread());
  bool cancelled = false;
  for (int allowed = 0; !light.lit(0, seed); allowed += cancelled ? 1 : 0) {
    int requests = 0;
    rig.scheduler.set_cancel([&] { return requests++ >= allowed; });
    cancelled = !light.step(0, seed);
  }
  CHECK(shine(rig, light) == shine(calm, expected));
}

TEST_CASE("a camera that moves while points get their light throws none of it away") {
  const Parameters split = with(small, {{"batch_gathers", "64"}, {"light_samples", "16"}, {"jacobi_level", "11"}});
  for (const Parameters& more : {Parameters{}, Parameters{{"node_shading", "dynamic"}}}) {
    CAPTURE(more.size());
    const Scene scene = load_scene("builtin:room");
    RenderSettings settings = settings_for(scene, 24, 2);
    RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings, with(split, more));
    const auto gathers = [&] { return session.technique().counters().at("gathers at nodes"); };
    const auto cancel_an_iteration = [&](int allowed) {
      session.scheduler().set_cancel([&] { return allowed-- <= 0; });
      session.iterate();
      CHECK(allowed < 0);
      session.scheduler().set_cancel(interrupt_requested);
    };
    const auto move = [&] {
      settings.camera.world_from_camera[3].x -= 0.1f;
      session.set_view(settings.camera, 12, 12, true);
      session.run({.iterations = 2});
      return mean(session.resolve().find("indirect")->pixels);
    };
    while (gathers() == 0) session.iterate();
    const double begun = gathers();
    cancel_an_iteration(3);
    const double shown = move();
    CHECK(shown > 0);
    CHECK(gathers() == begun);
    session.set_view(settings.camera, 24, 24, false);
    cancel_an_iteration(0);  // as the next drag does
    CHECK(move() > 0);
    session.set_view(settings.camera, 24, 24, false);
    session.run({.samples = 1});
    RenderSession fresh(Device::open(), scene, registry().find("micro_rendering"), settings, with(split, more));
    fresh.run({.samples = 1});
    CHECK(gathers() > begun);  // several batches
    CHECK(gathers() == fresh.technique().counters().at("gathers at nodes"));
    CHECK(session.resolve().find("indirect")->pixels == fresh.resolve().find("indirect")->pixels);
    CHECK(session.resolve().find("direct")->pixels == fresh.resolve().find("direct")->pixels);

    session.iterate();  // half of the next frame's light samples
    CHECK(gathers() == fresh.technique().counters().at("gathers at nodes"));
    cancel_an_iteration(1);
    CHECK(move() > 0.8 * shown);
  }
}
