// SPDX-License-Identifier: Apache-2.0
// Light that does not depend on the camera: kept from frame to frame, saved, loaded.
#include <doctest/doctest.h>

#include <cmath>

#include "saved_state.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Options quick = {{"texels", "2048"}, {"directions", "48"}, {"stop_error", "0"}, {"camera_samples", "4"}};

/// The camera of the scene's walk at a time.
SceneCamera camera_at(const Scene& scene, double seconds) {
  return camera_on_path(scene.camera_paths.front(), seconds);
}

double directions(RenderSession& session) { return session.technique().counters().at("directions"); }

std::unique_ptr<RenderSession> loaded(const std::filesystem::path& file, Scene scene, const Options& options,
                                      const SessionStart& start = {}) {
  return test::loaded("bundle_exchange", file, std::move(scene), options, start);
}

struct SavedState : test::SavedLight {
  SavedState(const Scene& scene, const Options& options) : test::SavedLight("bundle_exchange", scene, options) {}
};

/// The same state with another header or other contents.
void rewrite(const std::filesystem::path& file, const std::function<void(StateHeader&)>& edit_header,
             const std::function<void(std::vector<float4>&)>& edit_shown = {}) {
  const StateFile old(file);
  StateHeader header = old.header();
  edit_header(header);
  std::vector<float4> shown = old.get<float4>("shown");
  if (edit_shown) edit_shown(shown);
  const auto texels = old.get_value<uint64_t>("texels");
  const auto direct = old.get<float4>("shown_direct"), radiance = old.get<float4>("radiance");
  const auto progress = old.get<uint64_t>("progress");
  const auto errors = old.get<double>("errors");
  write_state_file(file, header, false, [&](StateWriter& chunks) {
    chunks.put_value("texels", texels);
    chunks.put("shown", shown);
    chunks.put("shown_direct", direct);
    chunks.put("radiance", radiance);
    chunks.put("progress", progress);
    chunks.put("errors", errors);
  });
}

/// A coarse picture of a view that moves: light is seen, and rests at `found` directions.
void check_coarse(RenderSession& run, uint32_t width, int iterations, double found) {
  run.set_view(camera_at(run.scene(), width), width, 11, true);
  for (int i = 0; i < iterations; ++i) run.iterate();
  const Film film = run.resolve();
  CHECK(film.width() == width);
  CHECK(mean(film.find("indirect")->pixels) > 0);
  CHECK(directions(run) == found);
}

/// The picture has the bits of a session that has had no other camera than that of the walk at `seconds`.
void check_alone(RenderSession& run, const Options& options, double seconds) {
  Scene alone = run.scene();
  alone.cameras.front() = camera_at(alone, seconds);
  const auto other = session("bundle_exchange", alone, -1, options);
  other->finish_light();
  CHECK(picture(*other) == picture(run));
}

}  // namespace

TEST_CASE("light is finished beside a small image") {
  check_light_beside_small_image("bundle_exchange", load_scene("builtin:cornell"), quick);
}

TEST_CASE("every frame of a walk has the bits of that camera alone") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  for (const Options& more : {Options{}, Options{{"direct_mode", "exchange"}, {"preview", "on"}},
                              Options{{"final_gather", "all"}, {"pixel_rays", "bundle"}},
                              Options{{"glossy_window", "8"}, {"history_alpha", "0.001"}}}) {
    CAPTURE(more.empty() ? std::string("default") : more.front().first);
    const Options options = with(quick, more);
    const auto walk = session("bundle_exchange", scene, -1, options);
    CHECK_FALSE(walk->finish_light());
    const double found = directions(*walk);
    CHECK(found == 48);
    std::vector<float> before;
    for (const double t : {1.3, 4.0}) {
      CAPTURE(t);
      walk->set_camera(camera_at(scene, t));
      CHECK_FALSE(walk->finish_light());
      CHECK(walk->iterations() == 0);
      const std::vector<float> image = picture(*walk);
      CHECK(directions(*walk) == found);
      CHECK(image != before);
      check_alone(*walk, options, t);
      before = image;
    }
  }
}

TEST_CASE("a coarse picture of a moving view lets the exchange rest, and loses nothing of it") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  for (const Options& more : {Options{{"batch", "7"}}, Options{{"preview", "on"}, {"debug_layers", "on"}}}) {
    CAPTURE(more.front().first);
    const Options options = with(with(few_texels, {{"directions", "96"}, {"camera_samples", "4"}}), more);
    const auto run = session("bundle_exchange", scene, -1, options);
    while (directions(*run) == 0) run->iterate();
    const double found = directions(*run);
    REQUIRE(found < 96);
    for (const uint32_t width : {12u, 12u, 7u}) check_coarse(*run, width, 3, found);
    run->set_view(camera_at(scene, 1.3), 24, 24, false);
    CHECK_FALSE(run->finish_light());
    CHECK(directions(*run) == 96);
    check_alone(*run, options, 1.3);
  }
}

TEST_CASE("pixels that gather along bundles let the exchange rest, too, once the batch that has begun is complete") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const Options options = with(few_texels, {{"directions", "480"},
                                            {"stop_error", "0"},
                                            {"camera_samples", "4"},
                                            {"batch", "64"},
                                            {"final_gather", "all"},
                                            {"pixel_rays", "bundle"}});
  const auto run = session("bundle_exchange", scene, -1, options);
  while (directions(*run) == 0) run->iterate();
  REQUIRE(directions(*run) < 300);
  run->iterate();  // into the next batch
  const double begun = directions(*run);
  run->set_view(camera_at(scene, 1), 12, 11, true);
  for (int i = 0; i < 20; ++i) run->iterate();
  const double found = directions(*run);
  CHECK(found <= begun + 64);
  for (const uint32_t width : {12u, 7u}) check_coarse(*run, width, 5, found);
  run->set_view(camera_at(scene, 1.3), 24, 24, false);
  CHECK_FALSE(run->finish_light());
  CHECK(directions(*run) == 480);
  run->set_camera(camera_at(scene, 1.3));
  check_alone(*run, options, 1.3);
}

TEST_CASE("texels=0 are those of the whole picture, though the scene changes while it is coarse") {
  const auto run = session("bundle_exchange", load_scene("builtin:cornell"), SessionStart{.width = 256},
                           {{"texels", "0"}, {"directions", "8"}, {"access_rays", "128"}, {"warm_start", "off"}});
  const auto sides = [&] { return run->technique().counters().at("sides"); };
  const double whole = sides();
  run->set_view(run->settings().camera, 32, 3, true);
  CHECK(sides() == whole);
  run->change_scene([](Scene& scene) {
    scene.materials.front().base_color.x *= 0.5f;
    SceneChange change;
    change.materials = {0};  // and all is built again
    change.topology = true;
    return change;
  });
  CHECK(sides() == whole);
}

TEST_CASE("a frame in which nothing changes began the exchange from nothing") {
  const auto run = session("bundle_exchange", load_scene("builtin:cornell"), -1, quick);
  run->finish_light();
  const std::vector<float> first = picture(*run);
  run->set_time(1);
  CHECK(run->last().samples == 0);
  CHECK(directions(*run) == 48);
  CHECK(picture(*run) == first);
}

TEST_CASE("light that is held stays as it is, however unfinished, until something but the camera changes") {
  const Scene scene = load_scene("builtin:cornell");
  const auto run = session("bundle_exchange", scene, -1, with(few_texels, {{"directions", "100000"}}));
  while (directions(*run) == 0) run->iterate();
  CHECK_FALSE(run->last().light_done);
  run->hold_light();
  const double found = directions(*run);
  for (const double t : {0.0, 2.0, 0.0}) {
    run->set_camera(camera_at(scene, t));
    run->run({.samples = 3});
    CHECK(run->last().light_done);
    CHECK(directions(*run) == found);
  }
  run->restart(1);
  while (directions(*run) == 0) run->iterate();
  CHECK_FALSE(run->last().light_done);
}

TEST_CASE("a loaded state propagates nothing and shows the bits of the session that saved it") {
  for (const char* name : {"builtin:cornell-mirror", "builtin:room"}) {
    const Scene scene = load_scene(name);
    for (const Options& more : {Options{}, Options{{"direct_mode", "exchange"}}}) {
      CAPTURE(name);
      CAPTURE(more.size());
      const SavedState saved(scene, with(quick, more));
      const auto other = loaded(saved.file, scene, with(quick, more));
      CHECK(directions(*other) == 48);
      CHECK_FALSE(other->finish_light());
      CHECK(other->iterations() == 0);
      CHECK(picture(*other) == picture(*saved.by));
      CHECK(directions(*other) == 48);
      SceneCamera moved = scene.cameras.front();
      moved.world_from_camera[3].x += 0.1f;
      for (RenderSession* run : {other.get(), saved.by.get()}) run->set_camera(moved);
      const std::vector<float> elsewhere = picture(*other);
      CHECK(picture(*saved.by) == elsewhere);
      CHECK(mean(indirect(*other)) > 0);
      // What was loaded is what was saved, again.
      other->save_state(saved.folder.path() / "b.state", true);
      const StateFile a(saved.file), b(saved.folder.path() / "b.state");
      const auto bytes = [](const StateFile& state) {
        std::vector<float> all;
        for (const float4& v : state.get<float4>("shown")) all.insert(all.end(), {v.x, v.y, v.z, v.w});
        return all;
      };
      CHECK(bytes(a) == bytes(b));
    }
  }
}

TEST_CASE("a state that was saved at another size has the atlas that it was saved with") {
  Options options = quick;
  options.front() = {"texels", "0"};
  const Scene scene = load_scene("builtin:cornell");
  const SavedState saved(scene, options);
  rewrite(saved.file, [](StateHeader&) {});
  const auto wide = loaded(saved.file, scene, options, {.width = 200});
  CHECK(wide->technique().counters().at("sides") == saved.by->technique().counters().at("sides"));
  const double expected = mean(indirect(*(saved.by->run({.samples = 3}), saved.by.get())));
  Scene same = scene;
  const auto narrow = loaded(saved.file, same, options);
  narrow->run({.samples = 3});
  CHECK(mean(indirect(*narrow)) == expected);
}

TEST_CASE("behind a loaded state a change of the lights propagates again, to the bits of a fresh start") {
  const Scene scene = load_scene("builtin:cornell");
  const SavedState saved(scene, quick);
  const auto sky = [](Scene& lit) {
    lit.environment = Environment{};
    SceneChange change;
    change.environment = true;
    return change;
  };
  for (const std::function<SceneChange(Scene&)>& edit : {std::function<SceneChange(Scene&)>(dim_lamps), {sky}}) {
    const auto run = loaded(saved.file, scene, quick);
    picture(*run);
    run->change_scene(edit);
    CHECK(directions(*run) == 0);
    run->finish_light();
    CHECK(directions(*run) == 48);
    Scene changed = scene;
    edit(changed);
    const auto fresh = session("bundle_exchange", changed, -1, quick);
    fresh->finish_light();
    CHECK(picture(*run) == picture(*fresh));
  }
}

TEST_CASE("a state of something else is refused, with the reason") {
  const Scene scene = load_scene("builtin:cornell");
  const SavedState saved(scene, quick);
  const auto load = [&](Scene other, const Options& options, const SessionStart& start = {}) {
    return [&saved, other = std::move(other), options, start] { loaded(saved.file, other, options, start); };
  };
  check_refusal(load(load_scene("builtin:cornell-mirror"), quick), ErrorClass::input,
                "it belongs to another scene (builtin:cornell)");
  check_refusal(load(scene, with(quick, {{"texels", "4096"}})), ErrorClass::usage,
                "it was saved with texels=2048, here it is 4096; give -p texels=2048");
  check_refusal(load(scene, quick, {.seed = 7}), ErrorClass::usage, "it was saved with --seed 1");
  check_refusal(load(scene, quick, {.max_bounces = 2}), ErrorClass::usage, "it was saved with --max-bounces -1");
  check_refusal(load(scene, with(quick, {{"pixel_rays", "bundle"}})), ErrorClass::usage,
                "bundle_exchange has no state to save or load: it gathers along new bundles");
  CHECK_NOTHROW(load(scene, with(quick, {{"camera_samples", "9"}}))());

  rewrite(saved.file, [](StateHeader& header) { header.technique_version += ".1"; });
  check_refusal(load(scene, quick), ErrorClass::input, "here is version");
  rewrite(saved.file, [&](StateHeader& header) {
    header.technique_version = registry().find("bundle_exchange").info().version;
    header.technique = "path_tracing";
  });
  check_refusal(load(scene, quick), ErrorClass::usage, "it is a state of path_tracing, not of bundle_exchange");
  rewrite(saved.file, [](StateHeader& header) {
    header.technique = "bundle_exchange";
    header.path_set += ",more";
  });
  check_refusal(load(scene, quick), ErrorClass::input, "it holds other light paths");
  rewrite(saved.file, [](StateHeader& header) {
    header.path_set.resize(header.path_set.size() - 5);
    header.parameters.emplace_back("older", "1");
  });
  check_refusal(load(scene, quick), ErrorClass::usage, "it was saved with older=1, here it is (none)");
}

TEST_CASE("values that no exchange brings are refused: NaN, another number of texel sides, absurd atlases") {
  const Scene scene = load_scene("builtin:cornell");
  const auto refuse = [&](const std::function<void(std::vector<float4>&)>& edit, const std::string& part) {
    const SavedState saved(scene, quick);
    rewrite(
        saved.file, [](StateHeader&) {}, edit);
    check_refusal([&] { loaded(saved.file, scene, quick); }, ErrorClass::input, part);
  };
  refuse([](std::vector<float4>& shown) { shown[17].y = std::nanf(""); }, "chunk 'shown': number 69 of");
  refuse([](std::vector<float4>& shown) { shown[17].y = -1; }, "chunk 'shown': number 69 of");
  refuse([](std::vector<float4>& shown) { shown[0].w = INFINITY; }, "chunk 'shown': number 3 of");
  refuse([](std::vector<float4>& shown) { shown.pop_back(); }, "chunk 'shown': it has ");
  const SavedState saved(scene, quick);
  const StateHeader header = StateFile(saved.file).header();
  for (const uint64_t texels : {uint64_t{0}, uint64_t{1} << 60}) {
    write_state_file(saved.file, header, false, [&](StateWriter& chunks) { chunks.put_value("texels", texels); });
    check_refusal([&] { loaded(saved.file, scene, quick); }, ErrorClass::input,
                  fmt::format("chunk 'texels': an atlas of {} texels", texels));
  }
  write_state_file(saved.file, header, false, [](StateWriter&) {});
  check_refusal([&] { loaded(saved.file, scene, quick); }, ErrorClass::input, "chunk 'texels': it is missing");
}

TEST_CASE("a technique without a state says so") {
  const auto run = session("path_tracing", load_scene("builtin:cornell"), -1, {});
  const TemporaryFolder folder;
  check_refusal([&] { run->save_state(folder.path() / "a.state", false); }, ErrorClass::usage,
                "path_tracing has no state to save or load: it keeps nothing from picture to picture");
  CHECK_FALSE(run->finish_light());  // there is none, and nothing is done
  CHECK(run->iterations() == 0);
}
