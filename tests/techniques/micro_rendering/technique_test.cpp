// SPDX-License-Identifier: Apache-2.0
// The whole technique: agreement with the path tracer restricted to the same paths, and with closed forms.
#include <doctest/doctest.h>

#include <cmath>

#include "made_scene.h"
#include "technique_fixture.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("indirect light is the path tracer's, over one and several bounces") {
  for (const char* scene : {"builtin:cornell", "builtin:room"}) {
    for (const int bounces : {1, 3}) {
      CAPTURE(scene);
      CAPTURE(bounces);
      const double mine = mean(indirect_light(load_scene(scene), "micro_rendering", 24, bounces, 8, small));
      const double expected = mean(indirect_light(load_scene(scene), "path_tracing", 24, bounces, 16, reference));
      CHECK(mine == test::relative(expected, 0.03));
    }
  }
}

TEST_CASE("virtual lights and photons bring the light of several bounces") {
  const double expected = mean(indirect_light(load_scene("builtin:room"), "path_tracing", 24, 3, 16, reference));
  const auto room = [](const Parameters& parameters) {
    return mean(indirect_light(load_scene("builtin:room"), "micro_rendering", 24, 3, 8, parameters));
  };
  Parameters lights = small;
  lights.emplace_back("multibounce", "instant_radiosity");
  lights.emplace_back("vpls", "64");
  lights.emplace_back("vpl_clamp", "1e5");
  lights.emplace_back("points_log2", "11");
  CHECK(room(lights) == test::relative(expected, 0.03));
  Parameters photons = small;
  photons.emplace_back("multibounce", "photon_map");
  photons.emplace_back("photons", "50000");
  CHECK(room(photons) == test::relative(expected, 0.03));
  photons.emplace_back("photon_direct", "on");
  CHECK(room(photons) == test::relative(expected, 0.04));
}

TEST_CASE("light paths follow shading normals as the path tracer does") {
  // Normals that lean by 17 degrees: without the ratio of the cosines 8 and 5 % too much light.
  Scene scene = load_scene("builtin:room");
  for (Mesh& mesh : scene.meshes)
    for (glm::vec3& n : mesh.normals) n = glm::normalize(n + 0.3f * glm::vec3(n.y, n.z, n.x));
  const double expected = mean(indirect_light(scene, "path_tracing", 24, 3, 16, reference));
  const Parameters lights =
      with(small, {{"multibounce", "instant_radiosity"}, {"vpls", "64"}, {"vpl_clamp", "1e5"}, {"points_log2", "11"}});
  CHECK(mean(indirect_light(scene, "micro_rendering", 24, 3, 8, lights)) == test::relative(expected, 0.03));
  const Parameters photons = with(small, {{"multibounce", "photon_map"}, {"photons", "50000"}});
  CHECK(mean(indirect_light(scene, "micro_rendering", 24, 3, 8, photons)) == test::relative(expected, 0.03));
}

TEST_CASE("virtual lights that are shown directly bring the light of the reference's paths") {
  const std::vector<float> expected = indirect_light(load_scene("builtin:room"), "path_tracing", 24, 2, 16, reference);
  const auto direct = [](const char* vpls) {
    return indirect_light(
        load_scene("builtin:room"), "micro_rendering", 24, 2, 4,
        with(small,
             {{"multibounce", "instant_radiosity"}, {"vpls", vpls}, {"vpl_clamp", "1000"}, {"gather_visible", "off"}}));
  };
  const std::vector<float> many = direct("512");
  CHECK(mean(many) == test::relative(mean(expected), 0.03));
  CHECK(relative_rmse(many, expected) < relative_rmse(direct("32"), expected));
}

TEST_CASE("pixel by pixel the room is the path tracer's, the better the larger the micro-buffers") {
  const std::vector<float> expected = indirect_light(load_scene("builtin:room"), "path_tracing", 16, 2, 64, reference);
  const auto error = [&](const char* micro_size) {
    Parameters parameters = {{"points_log2", "15"}, {"jacobi_level", "10"}, {"micro_size", micro_size}};
    const std::vector<float> image =
        indirect_light(load_scene("builtin:room"), "micro_rendering", 16, 2, 16, parameters);
    double squares = 0, level = mean(expected);
    for (size_t i = 0; i < image.size(); ++i) {
      const double difference = static_cast<double>(image[i]) - static_cast<double>(expected[i]);
      squares += difference * difference;
    }
    return std::sqrt(squares / static_cast<double>(image.size())) / level;
  };
  const double coarse = error("8"), fine = error("24");
  MESSAGE("RMSE over the mean: B = 8 ", coarse, ", B = 24 ", fine);
  CHECK(fine < 0.02);
  CHECK(fine < coarse);
}

TEST_CASE("a plane does not shine at itself, however it is turned") {
  for (const glm::vec3 up : {glm::vec3(0, 1, 0), glm::vec3(0.3f, 0.8f, -0.5f), glm::vec3(-0.1f, 0.2f, 0.9f)}) {
    CAPTURE(up.x);
    const glm::vec3 n = glm::normalize(up), t = glm::normalize(glm::cross(n, glm::vec3(0.2f, 0.1f, 0.9f))),
                    b = glm::cross(n, t);
    Scene scene;
    scene.source = "test:plane";
    add_instance(scene, add_mesh(scene, MeshBuilder("plane").quad(t + b, b - t, -t - b, t - b).take()),
                 add_lambert(scene, "white", glm::vec3(0.8f)));
    SceneLight light;
    light.type = LightType::directional;
    light.world_from_light = frame_along(glm::vec3(0), -n);
    light.intensity = glm::vec3(3.14159265f);
    scene.lights.push_back(light);
    scene.cameras.push_back(look_at_camera("above", 2.5f * n + 0.3f * t, glm::vec3(0), 40));
    // Direct light is 0.8. A sample at the horizon may meet a disc whose packed normal leans towards it.
    CHECK(mean(indirect_light(scene, "micro_rendering", 24, 1, 2, small)) < 1e-5);
  }
}

TEST_CASE("no light comes through a thin wall") {
  // A closed box cut in two by a wall of 1 cm; a lamp on one side, the camera in the other.
  Scene scene;
  scene.source = "test:wall";
  const int white = add_lambert(scene, "white", glm::vec3(0.7f));
  MeshBuilder box("box");
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) box.box_face({-1, 0, -1}, {1, 2, 1}, axis, side, true);
  add_instance(scene, add_mesh(scene, box.take()), white);
  add_instance(scene, add_mesh(scene, MeshBuilder("wall").box({-0.005f, 0, -1}, {0.005f, 2, 1}).take()), white);
  SceneLight light;
  light.world_from_light = frame_along({0.5f, 1, 0}, {0, -1, 0});
  scene.lights.push_back(light);
  scene.cameras.push_back(look_at_camera("dark", {-0.9f, 1, 0.9f}, {-0.3f, 0.9f, -0.4f}, 70));
  scene.cameras.push_back(look_at_camera("lit", {0.9f, 1, 0.9f}, {0.3f, 0.9f, -0.4f}, 70));
  const double dark = mean(indirect_light(scene, "micro_rendering", 24, 1, 4, small));
  std::swap(scene.cameras[0], scene.cameras[1]);
  const double lit = mean(indirect_light(scene, "micro_rendering", 24, 1, 4, small));
  MESSAGE("leak ", dark / lit);
  CHECK(dark < 0.005 * lit);
}

TEST_CASE("after a motion of a rigid object the picture is that of a fresh start, and only its matrix was touched") {
  Scene scene = load_scene("builtin:cornell");
  animate_last_instance(scene, AnimationPath::translation, {0, 0, 0, -0.1f, 0.05f, 0.1f});
  const RenderSettings settings = settings_for(scene, 24, 2);
  const TechniqueType& type = registry().find("micro_rendering");
  RenderSession moved(Device::open(), scene, type, settings, small);
  moved.run({.iterations = 1});
  const std::vector<float> before = moved.resolve().image();
  CHECK(moved.technique().counters().at("trees") == 2);
  moved.set_time(0.7);
  CHECK(moved.clocks().prepare < 0.1);
  moved.run({.iterations = 2});
  evaluate(scene, 0.7);
  RenderSession fresh(Device::open(), scene, type, settings, small);
  fresh.run({.iterations = 2});
  const std::vector<float> image = moved.resolve().image();
  CHECK(image == fresh.resolve().image());
  CHECK(image != before);
}

TEST_CASE("after a deformation the picture is that of a fresh start") {
  if (test::shared_scenes().empty()) return test::skip("third-party scenes");
  Scene scene = load_scene((test::shared_scenes() / "animated/Fox.glb").string());
  scene.environment = Environment{};
  scene.cameras.push_back(
      look_at_camera("side", scene.bounds().center() + 3 * scene.bounds().radius() * glm::vec3(0.7f, 0.3f, 0.6f),
                     scene.bounds().center(), 40));
  evaluate(scene, 0);
  const RenderSettings settings = settings_for(scene, 24, 1);
  const TechniqueType& type = registry().find("micro_rendering");
  RenderSession moved(Device::open(), scene, type, settings, small);
  moved.run({.iterations = 1});
  moved.set_time(0.2);
  moved.run({.iterations = 2});
  evaluate(scene, 0.2);
  RenderSession fresh(Device::open(), scene, type, settings, small);
  fresh.run({.iterations = 2});
  CHECK(moved.resolve().image() == fresh.resolve().image());
}

TEST_CASE("pixels between gathers are interpolated, and gather themselves where that fails") {
  const auto render = [](const char* step, const char* fail, double* gathers, double* failed) {
    Scene scene = load_scene("builtin:room");
    const RenderSettings settings = settings_for(scene, 48, 1);
    Parameters parameters = small;
    parameters.emplace_back("gather_step", step);
    parameters.emplace_back("upsample_fail", fail);
    RenderSession session(Device::open(), std::move(scene), registry().find("micro_rendering"), settings, parameters);
    session.run({.iterations = 2});
    *gathers = session.technique().counters().at("gathers");
    const Film film = session.resolve();
    *failed = film.find("upsampling_failed") ? mean(film.find("upsampling_failed")->pixels) : -1;
    return film.find("indirect")->pixels;
  };
  double all, some, few, failed_all, failed_some, failed_few;
  const std::vector<float> every = render("1", "0.05", &all, &failed_all),
                           second = render("2", "0.05", &some, &failed_some),
                           never = render("4", "0", &few, &failed_few);
  CHECK(failed_all == -1);
  CHECK(failed_some > 0);
  CHECK(failed_few == 0);
  CHECK(some == test::relative(all * (0.25 + failed_some), 0.03));
  CHECK(few == test::relative(all / 16, 0.1));
  double squares = 0;
  for (size_t i = 0; i < every.size(); ++i) squares += std::pow(static_cast<double>(every[i] - second[i]), 2);
  CHECK(std::sqrt(squares / static_cast<double>(every.size())) < 0.1 * mean(every));
  CHECK(mean(second) == test::relative(mean(every), 0.01));
  CHECK(mean(never) == test::relative(mean(every), 0.06));
}

TEST_CASE("the mean over frames of gathers at some pixels shows no lattice") {
  constexpr uint32_t size = 32;
  const auto room = [&](const char* step, uint64_t frames) {
    const Parameters parameters = with(small, {{"gather_step", step}, {"upsample_fail", "0"}});
    return indirect_light(load_scene("builtin:room"), "micro_rendering", size, 1, frames, parameters);
  };
  const std::vector<float> expected = room("1", 16), once = room("4", 1), often = room("4", 16);
  // RMSE at the pixels that the first frame gathers at, and at the others.
  const auto error = [&](const std::vector<float>& image, bool on_lattice) {
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < image.size(); ++i) {
      const size_t x = i / 3 % size, y = i / 3 / size;
      if ((x % 4 == 0 && y % 4 == 0) != on_lattice) continue;
      sum += std::pow(static_cast<double>(image[i] - expected[i]), 2);
      ++count;
    }
    return std::sqrt(sum / count) / mean(expected);
  };
  MESSAGE("1 frame: ", error(once, true), " on the lattice, ", error(once, false),
          " beside; 16 frames: ", error(often, true), ", ", error(often, false));
  CHECK(error(once, true) < 0.5 * error(once, false));
  CHECK(error(often, true) > 0.7 * error(often, false));
  CHECK(error(often, false) < 0.8 * error(once, false));
}

TEST_CASE("gathers at every 8th pixel") {
  constexpr uint32_t size = 64;
  const auto room = [](const char* step, uint64_t frames, const char* fail, double* gathers) {
    RenderSession session(Device::open(), load_scene("builtin:room"), registry().find("micro_rendering"),
                          settings_for(load_scene("builtin:room"), size, 1),
                          with(small, {{"gather_step", step}, {"upsample_fail", fail}, {"batch_gathers", "16384"}}));
    session.run({.iterations = frames});
    *gathers = session.technique().counters().at("gathers");
    return session.resolve().find("indirect")->pixels;
  };
  double all, some, few;
  const uint64_t frames = test::full_run() ? 64 : 8;  // in 64 frames each pixel once
  const std::vector<float> every = room("1", 1, "0.05", &all), eighth = room("8", 4, "0.05", &some),
                           never = room("8", frames, "0", &few);
  CHECK(all == size * size);
  CHECK(some < 4 * 0.25 * all);
  CHECK(few == static_cast<double>(frames) / 64 * all);
  MESSAGE("gathers ", some / 4 / all, ", mean ", mean(eighth) / mean(every), ", RMSE over it ",
          relative_rmse(eighth, every));
  MESSAGE("never: mean ", mean(never) / mean(every), ", RMSE over it ", relative_rmse(never, every));
  CHECK(mean(eighth) == test::relative(mean(every), 0.01));
  CHECK(relative_rmse(eighth, every) < 0.2);
  CHECK(mean(never) == test::relative(mean(every), 0.01));
}

TEST_CASE("the order of gathers changes nothing") {
  for (const char* step : {"1", "2"}) {
    CAPTURE(step);
    const auto room = [&](const char* morton) {
      const Scene scene = load_scene("builtin:cornell-glossy");
      RenderSession session(Device::open(), scene, registry().find("micro_rendering"), settings_for(scene, 16, 2),
                            with(small, {{"morton", morton}, {"gather_step", step}}));
      session.run({.iterations = 1});
      return std::pair(session.resolve().image(), session.technique().counters().at("node visits"));
    };
    const auto curve = room("on"), rows = room("off");
    CHECK(curve.first == rows.first);
    CHECK(curve.second == rows.second);
  }
}

TEST_CASE("the variants of the paper and the cheaper ones keep the mean") {
  const double expected = mean(indirect_light(load_scene("builtin:room"), "path_tracing", 16, 1, 64, reference));
  const struct {
    const char* name;
    Parameters parameters;
    double bound;
  } variants[] = {
      {"paper", {{"preset", "paper"}}, 0.05},
      {"depth_bits", {{"depth_bits", "8"}}, 0.01},
      {"raycast", {{"raycast", "off"}}, 0.02},
      {"backface", {{"backface", "cull"}}, 0.01},
      {"table", {{"warp", "table"}}, 0.01},
      {"nusselt", {{"warp", "nusselt"}}, 0.01},
      {"nearest", {{"splat", "nearest"}, {"cut_bound", "centre"}}, 0.05},
  };
  for (const auto& variant : variants) {
    CAPTURE(std::string(variant.name));
    const double mine = mean(indirect_light(load_scene("builtin:room"), "micro_rendering", 16, 1, 4,
                                            with(variant.parameters, {{"points_log2", "15"}, {"micro_size", "24"}})));
    MESSAGE((100 * (mine / expected - 1)), " %");
    CHECK(mine == test::relative(expected, variant.bound));
  }
}

TEST_CASE("layers to look inside: the chosen pixel's micro-buffer, level of the cut, lists, failed interpolations") {
  const auto film = [](const Parameters& parameters) {
    Scene scene = load_scene("builtin:room");
    const RenderSettings settings = settings_for(scene, 32, 1);
    RenderSession session(Device::open(), std::move(scene), registry().find("micro_rendering"), settings,
                          with(small, parameters));
    session.run({.iterations = 1});
    return session.resolve();
  };
  // Diffuse only: the mean over the micro-buffer is E / pi except for its holes, which the layer shows; the floor's
  // albedo is 0.7.
  const Film inspected = film({{"inspect_x", "9"}, {"inspect_y", "20"}});
  const std::vector<float>& buffer = inspected.find("micro_buffer")->pixels;
  const std::vector<float>& light = inspected.find("indirect")->pixels;
  const double albedo =
      static_cast<double>(light[3 * (20 * 32 + 9)]) / mean(buffer);  // 32 = 2 x 16: each pixel as 2 x 2
  CHECK(albedo >= 0.7 * (1 - 1e-4));
  CHECK(albedo < 0.7 * 1.03);
  const Film nothing = film({});
  CHECK(nothing.find("micro_buffer") == nullptr);
  CHECK(nothing.find("upsampling_failed") == nullptr);
  for (const char* step : {"1", "2"}) {
    const Film looks = film({{"gather_step", step}});
    for (const float level : looks.find("cut_level")->pixels) CHECK((level > 1 && level <= 13));
    CHECK(mean(looks.find("list_length")->pixels) > 0);
    for (const float visits : looks.find("node_visits")->pixels) CHECK(visits > 100);
  }
  // A pixel that does not gather shows the micro-buffer of the gather that it lies beside.
  CHECK(film({{"inspect_x", "9"}, {"inspect_y", "21"}, {"gather_step", "2"}, {"upsample_fail", "0"}})
            .find("micro_buffer")
            ->pixels == film({{"inspect_x", "8"}, {"inspect_y", "20"}, {"gather_step", "2"}, {"upsample_fail", "0"}})
                            .find("micro_buffer")
                            ->pixels);
  CHECK(mean(film({{"inspect_x", "9"}, {"inspect_y", "21"}, {"gather_step", "2"}}).find("micro_buffer")->pixels) > 0);
  const Film interpolated = film({{"gather_step", "2"}});
  for (const float failed : interpolated.find("upsampling_failed")->pixels) CHECK((failed == 0 || failed == 1));
}

TEST_CASE("triangles that nothing hits change no bit of a picture") {
  const Scene room = load_scene("builtin:cornell");
  Scene with_lines = room;
  const int lamp = add_material(with_lines, emitter(1000));
  add_threads(with_lines, 50, 0, 0);
  add_threads(with_lines, 50, 0, lamp);
  for (const char* layer : {"direct", "indirect"})
    CHECK(rendered_layer(with_lines, "micro_rendering", layer, 16, 2, 2, small) ==
          rendered_layer(room, "micro_rendering", layer, 16, 2, 2, small));
}

TEST_CASE("a gather_step above the image's size is the image's size, and reads nothing beside the image") {
  const auto at_step = [](const char* step) {
    Parameters parameters = small;
    parameters.emplace_back("gather_step", step);
    return indirect_light(load_scene("builtin:cornell"), "micro_rendering", 4, 1, 3, parameters);
  };
  CHECK(at_step("8") == at_step("4"));
}
