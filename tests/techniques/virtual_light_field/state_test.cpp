// SPDX-License-Identifier: Apache-2.0
// The settled field: kept from frame to frame, saved and loaded, the same bits whatever was done before.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "lucarium/scene/camera_path.h"
#include "saved_state.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Options saved_field = {{"dir_n", "4"}, {"cells", "32"}, {"texels", "2048"}, {"camera_samples", "4"}};

double lines(RenderSession& session) { return session.technique().counters().at("lines"); }

std::unique_ptr<RenderSession> loaded(const std::filesystem::path& file, Scene scene, const Options& options,
                                      const SessionStart& start = {}) {
  return test::loaded("virtual_light_field", file, std::move(scene), options, start);
}

struct SavedState : test::SavedLight {
  SavedState(const Scene& scene, const Options& options, int max_bounces = -1)
      : test::SavedLight("virtual_light_field", scene, options, max_bounces) {}
};

}  // namespace

TEST_CASE("light is finished beside a small image") {
  check_light_beside_small_image("virtual_light_field", load_scene("builtin:cornell"), saved_field);
}

TEST_CASE("every frame of a walk through the field has the bits of that camera alone") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  for (const Options& more : {Options{}, Options{{"preset", "walkthrough"}}}) {
    CAPTURE(more.empty() ? std::string("default") : more.front().second);
    const Options options = with(more, saved_field);
    const auto walk = session(scene, -1, options);
    CHECK_FALSE(walk->finish_light());
    const double found = lines(*walk);
    CHECK(found > 0);
    std::vector<float> before;
    for (const double t : test::full_run() ? std::vector<double>{1.3, 2.5, 4.0} : std::vector<double>{1.3}) {
      CAPTURE(t);
      const SceneCamera camera = camera_on_path(scene.camera_paths.front(), t);
      walk->set_camera(camera);
      CHECK_FALSE(walk->finish_light());
      CHECK(walk->iterations() == 0);
      const std::vector<float> image = picture(*walk);
      CHECK(lines(*walk) == found);
      CHECK(image != before);
      Scene alone = scene;
      alone.cameras.front() = camera;
      const auto other = session(alone, -1, options);
      other->finish_light();
      CHECK(picture(*other) == image);
      before = image;
    }
  }
}

TEST_CASE("a coarse picture of a moving view lets the field rest, and loses nothing of it") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  for (const Options& more : {Options{}, Options{{"preset", "walkthrough"}}}) {
    CAPTURE(more.empty() ? std::string("default") : more.front().second);
    const Options options = with(more, saved_field);
    const auto run = session(scene, -1, options);
    while (lines(*run) == 0) run->iterate();
    const double found = lines(*run);
    REQUIRE_FALSE(run->last().light_done);
    for (const uint32_t width : {12u, 12u, 7u}) {
      run->set_view(camera_on_path(scene.camera_paths.front(), width), width, 11, true);
      for (int i = 0; i < 3; ++i) run->iterate();
      const Film film = run->resolve();
      CHECK(film.width() == width);
      CHECK(mean(film.image()) > 0);
      CHECK(lines(*run) == found);
    }
    const SceneCamera camera = camera_on_path(scene.camera_paths.front(), 1.3);
    run->set_view(camera, 24, 24, false);
    CHECK_FALSE(run->finish_light());
    CHECK(lines(*run) > found);
    Scene alone = scene;
    alone.cameras.front() = camera;
    const auto other = session(alone, -1, options);
    other->finish_light();
    CHECK(lines(*run) == lines(*other));
    CHECK(picture(*other) == picture(*run));
  }
}

TEST_CASE("texels=0 are those of the whole picture, though the scene changes while it is coarse") {
  const auto run = session("virtual_light_field", load_scene("builtin:cornell"), SessionStart{.width = 256},
                           with(saved_field, {{"texels", "0"}, {"access_rays", "128"}}));
  const auto sides = [&] { return run->technique().counters().at("sides"); };
  const double whole = sides();
  run->set_view(run->settings().camera, 32, 3, true);
  CHECK(sides() == whole);
  run->change_scene(dim_lamps);
  CHECK(sides() == whole);
}

TEST_CASE("a loaded field propagates nothing and shows the bits of the session that saved it") {
  for (const char* name : {"builtin:cornell-mirror", "builtin:room", "builtin:caustic"}) {
    const Scene scene = load_scene(name);
    for (const Options& more : {Options{}, Options{{"preset", "walkthrough"}}, Options{{"split_layers", "off"}}}) {
      if (!test::full_run() && !more.empty() && std::string(name) != "builtin:cornell-mirror") continue;
      CAPTURE(name);
      CAPTURE(more.empty() ? std::string("default") : more.front().second);
      const Options options = with(more, saved_field);
      const SavedState saved(scene, options);
      const auto other = loaded(saved.file, scene, options);
      CHECK(lines(*other) == 0);
      CHECK_FALSE(other->finish_light());
      CHECK(other->iterations() == 0);
      CHECK(picture(*other) == picture(*saved.by));
      CHECK(lines(*other) == 0);
      SceneCamera moved = scene.cameras.front();
      moved.world_from_camera[3].x += 0.1f;
      for (RenderSession* run : {other.get(), saved.by.get()}) run->set_camera(moved);
      CHECK(picture(*saved.by) == picture(*other));
      CHECK(mean(indirect(*other)) > 0);
      other->save_state(saved.folder.path() / "b.state", true);
      const StateFile a(saved.file), b(saved.folder.path() / "b.state");
      REQUIRE(a.chunks().size() == b.chunks().size());
      for (const StateChunk& chunk : a.chunks()) {
        CAPTURE(chunk.name);
        const auto bytes = [&](const StateFile& state) {
          std::vector<uint32_t> all;
          if (chunk.element_bytes == 16)
            for (const uint4& v : state.get<uint4>(chunk.name)) all.insert(all.end(), {v.x, v.y, v.z, v.w});
          else if (chunk.element_bytes == 4)
            all = state.get<uint32_t>(chunk.name);
          return all;
        };
        CHECK(bytes(a) == bytes(b));
      }
    }
  }
}

TEST_CASE("a field of next to no light is loaded") {
  Scene scene = load_scene("builtin:cornell");
  for (SceneMaterial& material : scene.materials) material.emissive_factor *= 1e-8f;
  const SavedState saved(scene, saved_field);
  const auto run = loaded(saved.file, scene, saved_field);
  CHECK_FALSE(run->finish_light());
  CHECK(lines(*run) == 0);
}

TEST_CASE("a field of finite bounces is loaded with them, and at any size of the image") {
  Options options = saved_field;
  options[2].second = "0";  // texels: chosen by the size of the image
  const Scene scene = load_scene("builtin:cornell-mirror");
  const SavedState saved(scene, options, 2);
  const auto wide = loaded(saved.file, scene, options, {.width = 200, .max_bounces = 2});
  CHECK(wide->technique().counters().at("sides") == saved.by->technique().counters().at("sides"));
  const auto narrow = loaded(saved.file, scene, options, {.max_bounces = 2});
  CHECK(picture(*narrow) == picture(*saved.by));
}

TEST_CASE("behind a loaded field a change of the lights propagates again, to the bits of a fresh start") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const SavedState saved(scene, saved_field);
  const auto run = loaded(saved.file, scene, saved_field);
  picture(*run);
  run->change_scene(dim_lamps);
  run->finish_light();
  CHECK(lines(*run) > 0);
  Scene changed = scene;
  dim_lamps(changed);
  const auto fresh = session(changed, -1, saved_field);
  fresh->finish_light();
  CHECK(picture(*run) == picture(*fresh));
  // And a run that was not loaded: changed, and started over.
  saved.by->change_scene(dim_lamps);
  saved.by->finish_light();
  const std::vector<float> expected = picture(*fresh);
  CHECK(picture(*saved.by) == expected);
  saved.by->restart(1);
  saved.by->finish_light();
  CHECK(picture(*saved.by) == expected);
}

TEST_CASE("a field of something else is refused, with the reason") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const SavedState saved(scene, saved_field);
  const auto load = [&](Scene other, const Options& options, const SessionStart& start = {}) {
    return [&saved, other = std::move(other), options, start] { loaded(saved.file, other, options, start); };
  };
  check_refusal(load(load_scene("builtin:cornell"), saved_field), ErrorClass::input, "it belongs to another scene");
  check_refusal(load(scene, with(saved_field, {{"dir_n", "5"}})), ErrorClass::usage,
                "it was saved with dir_n=4, here it is 5; give -p dir_n=4");
  check_refusal(load(scene, with(saved_field, {{"eye_glossy", "vlf"}})), ErrorClass::usage,
                "saved with eye_glossy=trace");
  check_refusal(load(scene, saved_field, {.seed = 7}), ErrorClass::usage, "it was saved with --seed 1");
  check_refusal(load(scene, saved_field, {.max_bounces = 2}), ErrorClass::usage, "it was saved with --max-bounces -1");
  CHECK(picture(*loaded(saved.file, scene, with(saved_field, {{"camera_samples", "9"}, {"eye_interp", "nearest"}})))
            .size() > 0);
  const Options same_light = {{"cache_visibility", "0"}, {"inspect_line", "3"}, {"preview", "off"}};
  CHECK(picture(*loaded(saved.file, scene, with(saved_field, same_light))) == picture(*saved.by));
}

TEST_CASE("values that no propagation brings are refused: NaN, other numbers of cells and sides, absurd sizes") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const SavedState saved(scene, saved_field);
  const StateFile whole(saved.file);
  const StateHeader header = whole.header();
  struct Field {
    float scale;
    uint32_t shown, sweeps, cells;
  };
  struct Values {
    uint64_t texels;
    Field field;
    std::vector<char> why;
    std::vector<float4> direct, indirect, held;
    std::vector<uint32_t> total, direct_cells;
  };
  const Values right = {whole.get_value<uint64_t>("texels"), whole.get_value<Field>("field"),
                        whole.get<char>("why_done"),         whole.get<float4>("sides.direct"),
                        whole.get<float4>("sides.indirect"), whole.get<float4>("sides.held"),
                        whole.get<uint32_t>("cells.total"),  whole.get<uint32_t>("cells.direct")};
  const std::filesystem::path file = saved.folder.path() / "changed.state";
  const auto refuse = [&](const std::function<void(Values&)>& edit, const std::string& part) {
    Values values = right;
    edit(values);
    write_state_file(file, header, false, [&](StateWriter& chunks) {
      chunks.put_value("texels", values.texels);
      chunks.put_value("field", values.field);
      chunks.put("why_done", values.why);
      chunks.put("sides.direct", values.direct);
      chunks.put("sides.indirect", values.indirect);
      chunks.put("sides.held", values.held);
      chunks.put("cells.total", values.total);
      if (!values.direct_cells.empty()) chunks.put("cells.direct", values.direct_cells);
    });
    check_refusal([&] { loaded(file, scene, saved_field); }, ErrorClass::input, part);
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  refuse([](Values& v) { v.direct[17].y = nan; }, "chunk 'sides.direct': number 69 of");
  refuse([](Values& v) { v.indirect[0].w = infinite; }, "chunk 'sides.indirect': number 3 of");
  refuse([](Values& v) { v.held[2].x = -infinite; }, "chunk 'sides.held': number 8 of");
  refuse([](Values& v) { v.direct[3].z = -1e30f; }, "chunk 'sides.direct': number 14 of");
  refuse([](Values& v) { v.indirect[1].y = -1e-6f; }, "is -1e-06, not from 0 to ");
  refuse([](Values& v) { v.held[0].x = 1e30f; }, "chunk 'sides.held': number 0 of");
  refuse([](Values& v) { v.held.pop_back(); }, "chunk 'sides.held': it has ");
  refuse([](Values& v) { v.total.push_back(0); }, "chunk 'cells.total': it has ");
  refuse([](Values& v) { v.direct_cells.clear(); }, "chunk 'cells.direct': it is missing");
  refuse([](Values& v) { v.field.scale = nan; }, "chunk 'field': the scale nan");
  refuse([](Values& v) { v.field.scale = 0; }, "chunk 'field': the scale 0");
  refuse([](Values& v) { v.field.scale = 0.75f; }, "chunk 'field': the scale 0.75");
  refuse([](Values& v) { v.field.scale = 0x1p101f; }, "chunk 'field': the scale 2.5");
  refuse([](Values& v) { v.field.shown = 0; }, "chunk 'field': no sweep that is shown");
  refuse([](Values& v) { v.field.cells = 0xffffffffu; }, "chunk 'field': 4294967295 cells");
  write_state_file(file, header, false, [](StateWriter&) {});
  check_refusal([&] { loaded(file, scene, saved_field); }, ErrorClass::input, "it is missing");
}

TEST_CASE("samples per pixel counted before all light was there, so that --spp ended in a dark picture") {
  const auto run = session(load_scene("builtin:cornell"), -1, saved_field);
  bool seen = false;
  while (!run->last().light_done) {
    run->iterate();
    seen = seen || run->last().visible;
    if (!run->last().light_done) CHECK(run->last().samples == 0);
  }
  CHECK(seen);  // pictures meanwhile show what there is
  run->run({.samples = 3});
  CHECK(run->last().samples == 3);
}
