// SPDX-License-Identifier: Apache-2.0
// Interleaved bounces where specular lobes deliver too: furnaces of emission 1, some of whose walls are perfect
// mirrors. A mirror doubles the furnace and changes nothing: with albedo 0.8 radiance is 5 everywhere.
#include <doctest/doctest.h>

#include <cmath>

#include "bundle_rig.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

/// The unit box. Of the wall x = 0 the part z < `mirrored` is a mirror; where that is all of it, so is the wall y = 0.
Scene furnace(float mirrored, float albedo = 0.8f) {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(albedo)), mirror = add_metal(scene, "mirror", glm::vec3(1), 0);
  scene.materials[wall].emissive_factor = glm::vec3(1);
  const auto add = [&](MeshBuilder mesh, int material) {
    add_instance(scene, add_mesh(scene, std::move(mesh).take()), material);
  };
  for (int face = 1; face < 6; ++face)
    add(MeshBuilder("wall").box_face({0, 0, 0}, {1, 1, 1}, face / 2, face % 2, true),
        face == 2 && mirrored == 1 ? mirror : wall);
  const float m = mirrored;
  add(MeshBuilder("mirror").quad({0, 0, 0}, {0, 1, 0}, {0, 1, m}, {0, 0, m}), mirror);
  if (m < 1) add(MeshBuilder("rest").quad({0, 0, m}, {0, 1, m}, {0, 1, 1}, {0, 0, 1}), wall);
  return scene;
}

/// The unit box with three sheets of which half is there: emission 1 - albedo, so that radiance is 1 everywhere.
Scene veiled_box() {
  Scene scene;
  const int wall = add_lambert(scene, "wall", glm::vec3(0.8f)), veil = add_lambert(scene, "veil", glm::vec3(0.2f));
  scene.materials[wall].emissive_factor = glm::vec3(0.2f);
  scene.materials[veil].emissive_factor = glm::vec3(0.8f);
  scene.materials[veil].alpha_mode = AlphaMode::blend;
  scene.materials[veil].base_color.a = 0.5f;
  scene.materials[veil].double_sided = true;
  scene = test::box_scene({wall, wall, wall, wall, wall, wall}, std::move(scene));
  for (const float y : {0.25f, 0.5f, 0.75f})
    add_instance(scene, add_mesh(scene, MeshBuilder("veil").quad({0, y, 0}, {1, y, 0}, {1, y, 1}, {0, y, 1}).take()),
                 veil);
  return scene;
}

struct Result {
  double mean;     ///< E/π of all light over the diffuse walls
  float4 balance;  ///< at the end
};

Parameters with_balance(bool balance) {
  Parameters parameters;
  parameters.balance = balance;
  return parameters;
}

Result solve(const Scene& scene, Parameters parameters, int directions) {
  parameters.batch = 1;
  parameters.direct_mode = DirectMode::exchange;
  parameters.chain_share = 1;
  Channels channels;
  channels.emission = channels.chains = true;
  channels.count = 2;
  test::BundleRig rig(scene, 384, 0.5f, channels, parameters);
  rig.solve(make_sequence(parameters, 1), static_cast<uint64_t>(directions));
  const std::vector<AtlasMaterial> materials = rig.materials();
  const auto diffuse = [&](uint32_t side) { return materials[side].emission.x > 0; };
  return {rig.mean(rig.direct(), diffuse) + rig.mean(rig.indirect(), diffuse), rig.balance()};
}

}  // namespace

TEST_CASE("a furnace with a mirror: the balance counts what the mirror delivers") {
  // The mirror sends 5, the walls 4 of reflected light: half of a wall delivers a tenth of it.
  const Result with = solve(furnace(0.5f), with_balance(true), 256),
               without = solve(furnace(0.5f), with_balance(false), 256);
  MESSAGE("balance ", with.balance.x, ", light ", with.mean, ", without balance ", without.mean);
  CHECK(with.mean == test::relative(5, 0.003));
  CHECK(with.balance.x != 1);
  CHECK(without.mean < 4.95);  // so that balance can gain something
}

TEST_CASE("a box with veils: the balance weighs what is there of a surface, not all of its area") {
  const Result found = solve(veiled_box(), with_balance(true), 2048);
  MESSAGE("balance ", found.balance.x, ", light ", found.mean);
  CHECK(found.balance.x == test::relative(1, 0.03));  // it follows S, which forgets: noise of 0.01
  CHECK(found.mean == test::relative(1, 0.005));
}

TEST_CASE("a furnace with two walls of mirror: the balance is off") {
  // They deliver 2 x 5 of 2 x 5 + 4 x 4.
  const Result found = solve(furnace(1), with_balance(true), 256);
  MESSAGE("light ", found.mean);
  CHECK(found.balance.x == 1);
  CHECK(found.mean > 4.5);
  CHECK(found.mean < 5);
}

TEST_CASE("a furnace with a mirror, bounce after bounce: mirrors show lamps once") {
  Parameters parameters;
  parameters.interleave = Interleave::pingpong;
  parameters.block = 128;
  const Result found = solve(furnace(0.5f, 0.5f), parameters, 9 * 128);
  MESSAGE("light ", found.mean);
  CHECK(found.mean == test::relative(2 - std::pow(0.5, 9), 0.005));
}
