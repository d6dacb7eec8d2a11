// SPDX-License-Identifier: Apache-2.0
// Texels that lie partly under glass (SideAccessibility): below a sheet that nobody sees all is as it is without it.
#include <doctest/doctest.h>

#include <cmath>

#include "bundle_rig.h"
#include "glossy_box.h"
#include "invisible_sheet.h"
#include "saved_state.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;
using namespace lucarium::test;

namespace {

constexpr float kSheetEdge = 0.53f,
                kSheetHeight = 0.02f;  // x where the sheet ends, within texels of the floor; above it [m]

/// The unit box, walls as given, and above its floor the sheet, over x < kSheetEdge.
Scene box_with_sheet(const std::array<int, 6>& walls, Scene scene) {
  scene = box_scene(walls, std::move(scene));
  add_polygon(
      scene, {{0, kSheetHeight, 1}, {kSheetEdge, kSheetHeight, 1}, {kSheetEdge, kSheetHeight, 0}, {0, kSheetHeight, 0}},
      add_material(scene, invisible_glass()));
  return scene;
}

constexpr uint32_t kFloor = 2, kCeiling = 3;  // instances

/// One of them grey, all else black.
Scene dark_box(uint32_t grey_wall) {
  Scene scene;
  const int black = add_lambert(scene, "black", glm::vec3(0)), grey = add_lambert(scene, "grey", glm::vec3(0.5f));
  std::array<int, 6> walls{black, black, black, black, black, black};
  walls[grey_wall] = grey;
  return box_with_sheet(walls, std::move(scene));
}

/// Share of the light of the floor's part 0 < x < edge that the ceiling of the unit box receives: the midpoint rule.
double share_of_floor(double edge) {
  constexpr int n = 40;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        for (int l = 0; l < n; ++l) {
          const double x = (i + 0.5) / n * edge - (k + 0.5) / n, z = (j - l) / double{n}, d2 = x * x + z * z + 1;
          sum += 1 / (3.14159265358979 * d2 * d2);
        }
  return sum / (double{n} * n * n * n);
}

struct Halves {
  double open = 0, covered = 0;
};
/// Means of values of halves over an instance, by area.
Halves means_over(const BundleRig& rig, uint32_t instance, const std::vector<double>& values) {
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<double> areas = rig.half_areas();
  Halves sum, area;
  for (uint32_t half = 0; half < rig.half_count(); ++half) {
    if (rig.instance_of(texels[half % rig.sides()].triangle) != instance) continue;
    (half < rig.sides() ? sum.open : sum.covered) += areas[half] * values[half];
    (half < rig.sides() ? area.open : area.covered) += areas[half];
  }
  return {sum.open / area.open, sum.covered / area.covered};
}

Parameters all_chains(Transfer transfer = Transfer::ray) {
  Parameters parameters;
  parameters.chain_share = 1;
  parameters.balance = false;
  parameters.transfer = transfer;
  return parameters;
}

/// A floor under a sky of radiance 1, white or of metal, and on it a low grey wall that the camera sees from the front,
/// both below the middle of a sheet, or without it.
Scene wall_under_sheet(bool with_sheet, bool metal) {
  Scene scene;
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(1);
  SceneMaterial floor = lambert(0.8f);
  floor.metallic = metal ? 1.f : 0.f;
  floor.roughness = metal ? 0.6f : 1.f;
  add_horizontal(scene, 0, 0, 0, 3.2f, 3.2f, true, add_material(scene, floor));
  add_polygon(scene, {{0, 0, 0.2f}, {0, 0, -0.2f}, {0, 0.2f, -0.2f}, {0, 0.2f, 0.2f}},
              add_material(scene, lambert(0.5f)));
  if (with_sheet) add_horizontal(scene, 0, 0.3f, 0, 1.6f, 1.6f, true, add_material(scene, invisible_glass()));
  SceneCamera camera;
  camera.name = "front";
  camera.perspective = false;
  camera.xmag = camera.ymag = 0.09f;
  camera.world_from_camera = frame_along({0.2f, 0.1f, 0}, {-1, 0, 0});
  scene.cameras.push_back(camera);
  return scene;
}

Channels with_chains() {
  Channels channels;
  channels.chains = true;
  return channels;
}

}  // namespace

TEST_CASE("a sheet that nobody sees takes no light from texels that lie partly under it, and gives them none") {
  const Options few = {{"texels", "2400"}, {"directions", "256"}, {"chain_share", "1"}, {"camera_samples", "64"}};
  const Options all[] = {{{"direct_mode", "nee"}},
                         {{"direct_mode", "exchange"}},
                         {{"transfer", "texel"}, {"direct_mode", "exchange"}},
                         {{"direct_mode", "exchange"}, {"preview", "on"}, {"directions", "32"}}};
  for (const Options& options : all) {
    const auto run = session("bundle_exchange", invisible_sheet(), -1, with(few, options));
    run->run({.iterations = 400});
    const SheetRings mean = sheet_rings(run->resolve().image());
    const std::string which = options.front().first + "=" + options.front().second;
    CAPTURE(which);
    MESSAGE(which << ": inside " << mean.inside << ", outside " << mean.outside);
    CHECK(mean.inside == relative(1, 0.05));
    CHECK(mean.outside == relative(1, 0.05));
  }
}

TEST_CASE("the ceiling has the light of the floor's part under a sheet, and of that beside it, each alone") {
  for (const bool covered : {true, false}) {
    CAPTURE(covered);
    BundleRig rig(dark_box(kFloor), 700, 0.5f, with_chains(), all_chains());
    REQUIRE(rig.half_count() == 2 * rig.sides());
    const std::vector<AtlasTexel> texels = rig.texels();
    rig.set_direct([&](uint32_t half) {
      const bool lit = rig.instance_of(texels[half % rig.sides()].triangle) == kFloor;
      return lit && (half >= rig.sides()) == covered ? 3.14159265f : 0.f;
    });
    rig.solve(make_sequence({}, 3), 512);
    const double under = share_of_floor(kSheetEdge), beside = share_of_floor(1) - kSheetEdge * under;
    const double found = means_over(rig, kCeiling, rig.indirect()).open;
    const double expected = 0.5 * (covered ? kSheetEdge * under : beside);
    MESSAGE("found " << found << ", expected " << expected);
    CHECK(found == relative(expected, 0.03));
  }
}

TEST_CASE("floors under a sheet and beside it each have the light of the ceiling") {
  for (const Transfer transfer : {Transfer::ray, Transfer::texel}) {
    CAPTURE(static_cast<int>(transfer));
    BundleRig rig(dark_box(kCeiling), 700, 0.5f, with_chains(), all_chains(transfer));
    const std::vector<AtlasTexel> texels = rig.texels();
    rig.set_direct([&](uint32_t half) {
      return rig.instance_of(texels[half % rig.sides()].triangle) == kCeiling ? 3.14159265f : 0.f;
    });
    rig.solve(make_sequence({}, 3), 512);
    const double under = share_of_floor(kSheetEdge),
                 beside = (share_of_floor(1) - double{kSheetEdge} * under) / (1 - double{kSheetEdge});
    const Halves found = means_over(rig, kFloor, rig.indirect());
    MESSAGE("under: " << found.covered << ", expected " << 0.5 * under << "; beside: " << found.open << ", expected "
                      << 0.5 * beside);
    CHECK(found.covered == relative(0.5 * under, 0.03));
    CHECK(found.open == relative(0.5 * beside, 0.03));
  }
}

TEST_CASE("halves of texel sides have the area that a sheet covers, and that beside it, and send as they receive") {
  BundleRig rig(invisible_sheet(), 1200, 0.5f);
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<float4> albedo = rig.means().albedo().download();
  REQUIRE(albedo.size() == 2 * size_t{rig.sides()});
  Halves area;
  for (uint32_t half = 0; half < rig.half_count(); ++half)
    if (rig.instance_of(texels[half % rig.sides()].triangle) == 0)
      (half < rig.sides() ? area.open : area.covered) += double{albedo[half].w};
  CHECK(area.covered == relative(4 * half_sheet * half_sheet, 0.05));
  CHECK(area.open + area.covered == relative(4 * half_floor * half_floor, 1e-3));

  const auto sent = [](uint32_t half) { return static_cast<float>(1 + half * 37 % 11); };
  rig.send([&](uint32_t half) { return glm::vec3(sent(half)); });
  rig.run(make_sequence({}, 5), 64);
  const std::vector<double> counted = rig.counted();
  double delivered = 0, received = 0;
  for (uint32_t half = 0; half < rig.half_count(); ++half) {
    delivered += counted[half] * double{sent(half)};
    received += rig.sums()[half].x;
  }
  CHECK(delivered == relative(received, 1e-5));

  // Rays from a square, by their weight: pi times its area, wherever they end.
  Halves rays;
  for (uint32_t half = 0; half < rig.half_count(); ++half)
    if (rig.instance_of(texels[half % rig.sides()].triangle) == 0)
      (half < rig.sides() ? rays.open : rays.covered) += rig.sums()[half].w / 64;
  MESSAGE("covered " << area.covered << " m2, by rays " << rays.covered / 3.14159265);
  CHECK(rays.covered == relative(3.14159265 * area.covered, 0.03));
  CHECK(rays.open == relative(3.14159265 * area.open, 0.03));
}

TEST_CASE("halves in which no point lies have the direct light of the same half beside them") {
  BundleRig rig(invisible_sheet(0.6f), 1200, 0.5f);
  const std::vector<AtlasTexel> texels = rig.texels();
  const std::vector<double> light = rig.sampled_light(512), areas = rig.half_areas();
  const std::vector<uint32_t> levels = rig.point_levels();
  for (const bool covered : {false, true}) {
    CAPTURE(covered);
    double own = 0, own_area = 0, filled = 0, area = 0;
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      const uint32_t half = covered ? rig.sides() + side : side;
      // Halves of the floor that the sheet's edge crosses.
      if (rig.instance_of(texels[side].triangle) != 0 || !(areas[side] > 0) || !(areas[rig.sides() + side] > 0))
        continue;
      const bool has_point = half_has_point(levels[side], covered);
      (has_point ? own : filled) += areas[half] * light[half];
      (has_point ? own_area : area) += areas[half];
    }
    REQUIRE(area > 0);
    MESSAGE("filled " << filled / area << ", with points " << own / own_area);
    // The sheet hides most of the sky.
    CHECK(filled / area > (covered ? 0.1 : 0.75));
    CHECK(filled / area < (covered ? 0.35 : 1.001));
  }
}

TEST_CASE("glossy halves of texel sides each reflect what they have received") {
  for (const GlossyNorm norm : {GlossyNorm::self, GlossyNorm::mean}) {
    CAPTURE(static_cast<int>(norm));
    Parameters parameters = all_chains();
    parameters.glossy_window = 32;
    parameters.history_alpha = 0.01f;
    parameters.glossy_norm = norm;
    // Emission of 1 from all other walls: directly, or scattered once by the sheet.
    Scene scene;
    const int metal = add_metal(scene, "metal", glm::vec3(1), 0.7f), lamp = add_lambert(scene, "lamp", glm::vec3(0));
    scene.materials[lamp].emissive_factor = glm::vec3(1);
    scene = box_with_sheet({lamp, lamp, metal, lamp, lamp, lamp}, std::move(scene));
    BundleRig rig(std::move(scene), 700, 0.5f, glossy_channels(2), parameters);
    const SideState& state = rig.watch();
    const DirectionSequence sequence = make_sequence(parameters, 3, nullptr, true);
    constexpr int directions = 1024;
    rig.solve(sequence, directions);
    double expected = 0, weights = 0;  // value i counts i²
    for (int i = 1; i <= directions; ++i) {
      const auto mu = std::abs(static_cast<double>(sequence.at(static_cast<uint64_t>(i - 1)).direction.y));
      expected += double(i) * i * white_lobe_albedo(mu, 0.7);
      weights += double(i) * i;
    }
    expected /= weights;
    std::vector<double> reflected;
    for (const float4& light : state.history().download()) reflected.push_back(double{light.x});
    const Halves found = means_over(rig, kFloor, reflected);
    MESSAGE("open " << found.open << ", covered " << found.covered << ", expected " << expected);
    CHECK(found.open == relative(expected, 0.03));
    CHECK(found.covered == relative(expected, 0.03));
  }
}

TEST_CASE("a preview smooths covered halves among themselves, and open ones") {
  BundleRig rig(dark_box(kFloor), 700, 0.5f);
  rig.solve(make_sequence({}, 3), 8);
  std::vector<float> values;
  for (uint32_t half = 0; half < rig.half_count(); ++half) values.push_back(half < rig.sides() ? 1.f : 5.f);
  const std::vector<double> smooth = rig.smooth(values, 100);
  for (uint32_t half = 0; half < rig.half_count(); ++half) CHECK(smooth[half] == relative(double{values[half]}, 1e-5));
}

TEST_CASE("a wall under glass has the light of the covered floor before it, by bundles, by chains and by histories") {
  const auto light = [](const char* technique, const Scene& scene, uint64_t iterations, const Options& options) {
    const auto run = session(technique, scene, -1, options);
    run->run({.iterations = iterations});
    return mean(run->resolve().image());
  };
  const Options few = {{"texels", "1500"},      {"access_gap", "16"}, {"directions", "256"},
                       {"camera_samples", "0"}, {"chain_share", "1"}, {"stop_error", "0"},
                       {"batch", "1"},          {"eye_share", "0"},   {"history_alpha", "0.05"}};
  const Options bundles = {{"final_gather", "all"}, {"pixel_rays", "bundle"}};
  const std::vector<Options> all[] = {{{{"transfer", "ray"}},
                                       {{"transfer", "texel"}},
                                       {{"final_gather", "all"}},
                                       bundles,
                                       with(bundles, {{"direct_mode", "exchange"}, {"pixel_size", "2"}})},
                                      {{{"glossy_window", "0"}}, {{"glossy_window", "32"}, {"directions", "1024"}}}};
  for (const bool metal : {false, true}) {
    CAPTURE(metal);
    const double expected = light("path_tracing", wall_under_sheet(false, metal), 8, {{"samples_per_iteration", "64"}});
    for (const Options& options : all[metal ? 1 : 0]) {
      const std::string which = options.front().second + " " + options.back().second;
      CAPTURE(which);
      const double found = light("bundle_exchange", wall_under_sheet(true, metal),
                                 options.size() > 1 && metal ? 1032 : 264, with(few, options));
      MESSAGE(which << ": " << found << ", path traced without glass " << expected);
      CHECK(found == relative(expected, 0.05));
    }
  }
}

TEST_CASE("layers of texel sides are those of the half that a pixel sees, their accessibility that of both") {
  Scene scene = invisible_sheet();
  SceneMaterial& metal = scene.materials[static_cast<size_t>(scene.instances[0].material)];
  metal.metallic = 1;
  metal.roughness = 0.7f;
  const auto run = session("bundle_exchange", std::move(scene), -1,
                           {{"texels", "1200"},
                            {"directions", "64"},
                            {"glossy_window", "8"},
                            {"history_alpha", "0.05"},
                            {"chain_share", "1"},
                            {"debug_layers", "on"}});
  run->run({.iterations = 40});
  const Film film = run->resolve();
  const auto at = [&](const char* layer, size_t x) { return film.find(layer)->pixels[3 * (12 * 24 + x)]; };
  for (const size_t x : {size_t{1}, size_t{12}}) CHECK(at("accessibility", x) == relative(1, 1e-4));
  MESSAGE("history beside " << at("direction_history", 1) << ", under " << at("direction_history", 12));
  CHECK(at("direction_history", 12) > 0.5f * at("direction_history", 1));
}

TEST_CASE("a loaded state knows which parts of texel sides are covered") {
  const Options options = {{"texels", "1200"}, {"directions", "48"}, {"stop_error", "0"}, {"camera_samples", "4"}};
  const Scene scene = invisible_sheet();
  const SavedLight saved("bundle_exchange", scene, options);
  const auto other = loaded("bundle_exchange", saved.file, scene, options);
  CHECK(picture(*other) == picture(*saved.by));
}
