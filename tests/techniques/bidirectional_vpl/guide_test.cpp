// SPDX-License-Identifier: Apache-2.0
// guide: what mirrors and glass show of caustics has less noise, and nothing else changes.
#include "bidirectional_rig.h"
#include "bidirectional_vpl/shared/guide_photon.h"
#include "lucarium/compute/program/source_library.h"
#include "made_scene.h"
#include "polygon_irradiance.h"
#include "tolerance.h"

const lucarium::EmbeddedSources& test_bidirectional_vpl_kernels();
const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

const float kAlbedo = 0.5f, kLamp = 0.1f;  ///< of the wall; half a side of the lamp [m]

/// A lamp shines down on a mirror at y = 0, beside a wall at x = 1 whose light of one bounce is the mirrored lamp's.
/// The camera sees the wall by a second mirror, in parallel rays of a square of `half` [m].
Scene mirrored_caustic(float half) {
  Scene scene;
  SceneMaterial mirror;
  mirror.roughness = 0;
  const int shiny = add_material(scene, mirror);
  add_horizontal(scene, 0, 0, 0, 3, 3, true, shiny);
  add_horizontal(scene, 0, 1, 0, 2 * kLamp, 2 * kLamp, false, add_material(scene, emitter(25)));
  add_polygon(scene, {{1, 0, -1.5f}, {1, 0, 1.5f}, {1, 2, 1.5f}, {1, 2, -1.5f}}, add_material(scene, lambert(kAlbedo)));
  add_polygon(scene, {{-0.5f, 0.3f, -1.6f}, {0.1f, 0.3f, -1.6f}, {0.1f, 0.9f, -1.6f}, {-0.5f, 0.9f, -1.6f}}, shiny);
  scene.cameras = {look_orthographic({-1.4f, 0.6f, 0}, {-0.2f, 0.6f, -1.6f}, half)};
  return scene;
}

/// Radiance of what the camera sees, by Lambert's formula.
double caustic_radiance(double half) {
  const double lamp = double{kLamp};
  const std::vector<glm::dvec3> image = {{-lamp, -1, -lamp}, {lamp, -1, -lamp}, {lamp, -1, lamp}, {-lamp, -1, lamp}};
  const int grid = 32;
  double irradiance = 0;
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j) {
      // Parallel rays meet the wall at an angle with cosine 0.6.
      const glm::dvec3 point(1, 0.6 + (2 * (i + 0.5) / grid - 1) * half, (2 * (j + 0.5) / grid - 1) * half / 0.6);
      irradiance += polygon_irradiance(point, {-1, 0, 0}, image) / (grid * grid);
    }
  return 25 * irradiance * double{kAlbedo} / M_PI;
}

}  // namespace

TEST_CASE("guide: a mirror shows the light of another one on a wall, by Lambert's formula") {
  const float half = 0.2f;
  const Scene scene = mirrored_caustic(half);
  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = 1;
  picture.iterations = full_run() ? 2048 : 32;
  // Roulette from the wall on: it must not end what the guide has made likely.
  const auto estimated = [&](const char* guide) {
    return indirect(scene, picture, {{"light_paths", "8192"}, {"camera_edges", "1"}, {"guide", guide}});
  };
  const Estimate guided = estimated("on"), unguided = estimated("off");
  ClosedForms table;
  table.add("guided", guided, caustic_radiance(double{half}));
  table.check(0.02);
  MESSAGE("errors: " << guided.error << ", without a guide " << unguided.error);
  CHECK(guided.error < 0.25 * unguided.error);
}

TEST_CASE("guide: pictures of a caustic have the same light with less noise") {
  const Scene scene = load_scene("builtin:caustic");
  Picture picture;
  picture.width = 80;
  picture.height = 45;
  picture.max_bounces = 4;
  picture.iterations = full_run() ? 1024 : 32;
  const auto rendered = [&](const char* guide) {
    std::vector<double> means;
    double squares = 0;
    std::vector<std::vector<float>> images;
    picture.seed = 1000;
    for (const Film& film : films(scene, "bidirectional_vpl", picture, {{"guide", guide}, {"adapt", "off"}}, kSeeds)) {
      images.push_back(film.find("indirect")->pixels);
      means.push_back(mean_of(images.back()));
    }
    for (size_t i = 0; i < images.front().size(); ++i) {
      double mean = 0;
      for (const std::vector<float>& image : images) mean += static_cast<double>(image[i]) / kSeeds;
      for (const std::vector<float>& image : images) squares += std::pow(static_cast<double>(image[i]) - mean, 2);
    }
    return std::pair(squares, estimate_of(means));
  };
  const auto [guided, light] = rendered("on");
  const auto [unguided, expected] = rendered("off");
  MESSAGE("squared error, guided over not: " << guided / unguided);
  CHECK(guided < 0.7 * unguided);
  INFO(light.mean, " +- ", light.error, ", not guided ", expected.mean, " +- ", expected.error);
  CHECK(std::abs(light.mean - expected.mean) <= 5 * std::hypot(light.error, expected.error));
}

TEST_CASE("guide: in a shining box with a mirror all directions have their light") {
  // Every wall shines with 1 and reflects a half, the mirror all: light is 2 everywhere, of which a scattering has 1.
  Scene scene;
  SceneMaterial shining = lambert(0.5f), mirror;
  shining.emissive_factor = glm::vec3(1);
  mirror.roughness = 0;
  mirror.double_sided = true;
  add_box(scene, glm::vec3(-1), glm::vec3(1), true, add_material(scene, shining));
  add_polygon(scene, {{-0.8f, -0.8f, -0.9f}, {0.8f, -0.8f, -0.9f}, {0.8f, 0.8f, -0.9f}, {-0.8f, 0.8f, -0.9f}},
              add_material(scene, mirror));
  scene.cameras = {look_orthographic({0.2f, 0.1f, 0.5f}, {-0.1f, 0, -0.9f}, 0.3f)};
  Picture picture;
  picture.width = picture.height = 16;
  picture.max_bounces = -1;
  picture.iterations = full_run() ? 512 : 16;
  std::vector<double> means;
  picture.seed = 30;
  for (const Film& film : films(scene, "bidirectional_vpl", picture, {}, kSeeds))
    means.push_back(mean_of(image_of(film)));
  ClosedForms table;
  table.add("all", estimate_of(means), 2);
  table.check(0.02);
}

TEST_CASE("guide: directions are sampled with the density that they are weighed by") {
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(test_bidirectional_vpl_kernels());
  const Program program(*test_device(), library, {"test_bidirectional_vpl/guide", {"test_bidirectional_vpl/guide.cl"}});
  std::vector<GuidePhoton> all(BIDIRECTIONAL_GUIDE_WINDOW);
  for (size_t i = 0; i < all.size(); ++i) {
    const double z = 0.9 - 1.1 * static_cast<double>(i) / static_cast<double>(all.size()), r = std::sqrt(1 - z * z);
    const double angle = 2.4 * static_cast<double>(i);
    all[i].direction = {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
                        static_cast<float>(z), 0.1f + 0.4f * static_cast<float>(i % 4) / 3};
  }
  const auto photons = test_buffer(all);
  // Every other photon guides, and some of them from below one of the normals.
  const uint32_t mask = 0x5555'5555u;
  const float4 n_g{0, 0, 1, 0}, n_s{0.6f, 0, 0.8f, 0};
  const auto bind = [&](PassBuilder& pass, uint32_t count) {
    pass.arg("count", count).arg("photons", photons).arg("mask", mask).arg("n_g", n_g).arg("n_s", n_s);
  };
  const uint32_t samples = 400'000, steps = 1000;
  const auto sampled = test_buffer<float4>(samples);
  run_kernel(program, "sample_guides", samples, 64, [&](PassBuilder& pass) {
    bind(pass, samples);
    pass.arg("directions", sampled);
  });
  std::vector<float4> grid;
  for (uint32_t i = 0; i < steps; ++i)
    for (uint32_t j = 0; j < steps; ++j) {
      const double z = 2 * (i + 0.5) / steps - 1, r = std::sqrt(1 - z * z), angle = 2 * M_PI * (j + 0.5) / steps;
      grid.push_back(
          {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)), static_cast<float>(z), 0});
    }
  const auto directions = test_buffer(grid);
  const auto densities = test_buffer<float>(grid.size());
  run_kernel(program, "weigh_guides", grid.size(), 64, [&](PassBuilder& pass) {
    bind(pass, static_cast<uint32_t>(grid.size()));
    pass.arg("directions", directions).arg("densities", densities);
  });
  // The mean of each test function over samples, and its integral times the density.
  const std::vector<float> density = densities.download();
  const std::vector<float4> found = sampled.download();
  for (const glm::dvec3& axis :
       {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(-0.6, 0, 0.8), glm::dvec3(0, 0.6, 0.8), glm::dvec3(0, -1, 0)}) {
    const auto value = [&](const float4& d) {
      const double cosine = glm::dot(axis, glm::dvec3(d.x, d.y, d.z));
      return axis == glm::dvec3(0) ? 1 : std::max(cosine, 0.0) * std::max(cosine, 0.0);
    };
    double mean = 0, squares = 0, integral = 0;
    for (const float4& d : found) {
      const double v = d.w > 0 ? value(d) : 0;
      mean += v / samples;
      squares += v * v / samples;
    }
    for (size_t i = 0; i < grid.size(); ++i)
      integral += value(grid[i]) * static_cast<double>(density[i]) * 4 * M_PI / static_cast<double>(grid.size());
    CAPTURE(axis.x);
    CAPTURE(axis.y);
    CHECK(std::abs(mean - integral) <= 5 * std::sqrt((squares - mean * mean) / samples) + 1e-4);
    CHECK(integral < 1);
  }
}

TEST_CASE("guide: narrow lobes have their tails and their middle") {
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(test_bidirectional_vpl_kernels());
  const Program program(*test_device(), library, {"test_bidirectional_vpl/guide", {"test_bidirectional_vpl/guide.cl"}});
  const double width = 1e-3;
  std::vector<GuidePhoton> all(BIDIRECTIONAL_GUIDE_WINDOW);
  all.front().direction = {0, 0, 1, static_cast<float>(width)};
  const auto photons = test_buffer(all);
  const uint32_t samples = 100'000;
  const auto sampled = test_buffer<float4>(samples);
  run_kernel(program, "sample_guides", samples, 64, [&](PassBuilder& pass) {
    pass.arg("count", samples).arg("photons", photons).arg("mask", 1u);
    pass.arg("n_g", float4{0, 0, 1, 0}).arg("n_s", float4{0, 0, 1, 0}).arg("directions", sampled);
  });
  // Of the tangents t of a GGX distribution w^2 / (w^2 + t^2) are larger.
  const std::vector<float4> found = sampled.download();
  for (const double bound : {0.1, 0.3, 1.0, 3.0}) {
    const double expected = bound * bound / (1 + bound * bound);
    double below = 0;
    for (const float4& d : found)
      if (std::hypot(static_cast<double>(d.x), static_cast<double>(d.y)) < bound * width * static_cast<double>(d.z))
        below += 1.0 / samples;
    CAPTURE(bound);
    CHECK(std::abs(below - expected) < 5 * std::sqrt(expected * (1 - expected) / samples));
  }
}

TEST_CASE("guide: an iteration that is cancelled collects nothing, and neither do the light paths before the first") {
  const Scene scene = load_scene("builtin:caustic");
  int requests = 0;
  std::map<std::string, double> counters;  // at the end
  // Cancels the next iteration at its request `cancelled_at`, if it is above 0; counts the requests of the iteration.
  const auto image = [&](uint64_t before, int cancelled_at) {
    RenderSettings settings;
    settings.width = settings.height = 24;
    settings.max_bounces = 4;
    settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
    settings.camera = scene.cameras.front();
    RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings,
                          {{"light_paths", "2048"}});
    if (before > 0) session.run({.iterations = before});
    requests = 0;
    session.scheduler().set_cancel([&] { return ++requests == cancelled_at; });
    session.iterate();
    session.scheduler().set_cancel([] { return false; });
    CHECK(session.last().samples == (cancelled_at > 0 ? before : before + 1));
    while (session.last().samples < 4) session.iterate();
    counters = session.technique().counters();
    CHECK(counters.at("guide_photons") > 4 * BIDIRECTIONAL_GUIDE_WINDOW);
    return image_of(session.resolve());
  };
  for (const uint64_t before : {0, 2}) {
    const std::vector<float> undisturbed = image(before, 0);
    const std::map<std::string, double> counted = counters;
    const int all = requests;
    // The last ones are in the sample itself.
    for (const int at : {1, all / 4, all / 2, all - 40, all - 10, all - 1}) {
      CHECK(image(before, at) == undisturbed);
      CHECK(counters == counted);
    }
  }
}

TEST_CASE("guide: light paths before the first sample are counted as all others") {
  const Scene scene = load_scene("builtin:caustic");
  RenderSettings settings;
  settings.width = settings.height = 32;
  settings.max_bounces = 4;
  settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
  settings.camera = scene.cameras.front();
  const auto counters = [&](const char* guide) {
    RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings,
                          {{"light_paths", "4096"}, {"guide", guide}});
    session.run({.iterations = 2});
    return session.technique().counters();
  };
  const auto with = counters("on"), without = counters("off");
  CHECK(without.count("guide_light_paths") == 0);
  CHECK(without.at("light_paths") == 2 * 4096);
  const double before = with.at("guide_light_paths");
  CHECK(before >= 2 * 4096);
  CHECK(with.at("light_paths") == 2 * 4096 + before);
  // A path has as many rays and vertices as one of a sample.
  for (const char* const name : {"light_path_rays", "light_vertices", "splat_rays"}) {
    CAPTURE(name);
    const double expected = without.at(name) / without.at("light_paths");
    CHECK(with.at(name) / with.at("light_paths") == within(expected, 0.05 * expected));
  }
}

TEST_CASE("guide: light paths stay where a mirror shows a caustic, and photons are those of caustics alone") {
  RenderSettings settings;
  const Scene scene = load_scene("builtin:caustic");
  settings.width = 160;
  settings.height = 90;
  settings.max_bounces = 4;
  settings.pixel_sampling = LUCARIUM_PIXEL_JITTER;
  settings.camera = scene.cameras.front();
  RenderSession session(test_device(), scene, registry().find("bidirectional_vpl"), settings);
  session.run({.iterations = 24});
  const auto counters = session.technique().counters();
  CHECK(counters.at("adapted_light_paths") == 1);
  CHECK(counters.at("guide_photons") > 1000);
  // Caustics alone: a fortieth of the light paths, of which some are traced before the first sample.
  CHECK(counters.at("guide_photons") < 0.1 * counters.at("light_paths"));
  const Scene room = load_scene("builtin:room");
  settings.camera = room.cameras.front();
  settings.width = settings.height = 16;
  RenderSession plain(test_device(), room, registry().find("bidirectional_vpl"), settings);
  plain.run({.iterations = 1});
  CHECK(plain.technique().counters().count("guide_photons") == 0);
  // Surfaces with a texture are not stored eight at once: a white one changes no photon.
  const auto photons = [&](bool textured) {
    Scene caustic = scene;
    if (textured) {
      caustic.images.push_back({"white", 1, 1, {255, 255, 255, 255}});
      caustic.textures.push_back({static_cast<int>(caustic.images.size()) - 1, Wrap::clamp, Wrap::clamp, true, false});
      for (SceneMaterial& m : caustic.materials)
        m.metallic_roughness_texture.texture = static_cast<int>(caustic.textures.size()) - 1;
    }
    settings.camera = caustic.cameras.front();
    RenderSession kept(test_device(), caustic, registry().find("bidirectional_vpl"), settings,
                       {{"light_paths", "4096"}, {"adapt", "off"}});
    kept.run({.iterations = 2});
    return kept.technique().counters().at("guide_photons");
  };
  const double at_plain = photons(false);
  CHECK(at_plain > 100);
  CHECK(photons(true) == at_plain);
}
