// SPDX-License-Identifier: Apache-2.0
// The atlas after changes of geometry and materials.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "context.h"
#include "lucarium/scene/builtin/scenes.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Texel sides after a change of geometry lie on the triangles as they are now, and their areas sum to the surface's.
void check_follows(const AtlasContext& context) {
  const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
  const auto texels = context.atlas->texels().download();
  const auto points = context.atlas->surface_points().download();
  const auto ranges = context.atlas->ranges().download();
  const auto pieces = context.atlas->pieces().download();
  double area = 0;
  for (uint32_t side = 0; side < texels.size(); ++side) {
    const uint32_t t = texels[side].triangle;
    const glm::dvec3 exact = point_on(g, t, texels[side].b1, texels[side].b2);
    CHECK(glm::length(glm::dvec3(points[side].position.xyz()) - exact) < 1e-5);
    const glm::dvec3 n = glm::cross(corner(g, t, 1) - corner(g, t, 0), corner(g, t, 2) - corner(g, t, 0));
    const uint32_t k = context.atlas->info().double_sided_count;
    const bool back = side >= k && side < 2 * k;
    CHECK(glm::dot(glm::dvec3(points[side].normal.xyz()), glm::normalize(n)) == test::relative(back ? -1 : 1, 1e-4));
    double expected = 0;
    for (uint32_t i = ranges[side].x; i < ranges[side].x + ranges[side].y; ++i)
      expected += double(pieces[i].fraction) * area_of(g, pieces[i].triangle);
    CHECK(double(texels[side].area) == test::relative(expected, 1e-4));
    area += double(texels[side].area);
  }
  CHECK(area == test::relative(side_area(g), 1e-6));
}

}  // namespace

TEST_CASE("a rigid motion moves the texel sides and keeps their areas") {
  AtlasContext context(make_builtin_scene("cornell"), 4000);
  const auto before = context.atlas->texels().download();
  const uint64_t generation = context.atlas->generation();
  SceneChange change;
  for (int i = 0; i < int(context.scene.instances.size()); i += 2) {
    SceneInstance& instance = context.scene.instances[size_t(i)];
    change.moved_instances.push_back(i);
    change.previous_world_from_object.push_back(instance.world_from_object);
    instance.world_from_object =
        glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0.3f, 1, -0.2f)), 0.7f, glm::normalize(glm::vec3(1, 2, 3))) *
        instance.world_from_object;
  }
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == generation);
  check_follows(context);
  const auto after = context.atlas->texels().download();
  for (size_t i = 0; i < after.size(); ++i)
    CHECK(double(after[i].area) == test::relative(double(before[i].area), 1e-4));
}

TEST_CASE("a deformation: areas follow the triangles, and sum to what a rebuilt atlas has") {
  Scene scene = make_builtin_scene("furnace");
  for (SceneInstance& instance : scene.instances)
    instance.pose = std::make_shared<Mesh>(scene.meshes[size_t(instance.mesh)]);
  AtlasContext context(std::move(scene), 4000);
  SceneChange change;
  for (int i = 0; i < int(context.scene.instances.size()); ++i) {
    Mesh pose = *context.scene.instances[size_t(i)].pose;
    for (glm::vec3& p : pose.positions)
      p = glm::vec3(1.5f * p.x + 0.2f * std::sin(3 * p.y), p.y * (1 + 0.3f * p.x), 0.7f * p.z);
    context.scene.instances[size_t(i)].pose = std::make_shared<Mesh>(std::move(pose));
    change.deformed_instances.push_back(i);
  }
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  check_follows(context);
  const auto sum = [](const SurfaceAtlas& atlas) {
    double area = 0;
    for (const AtlasTexel& texel : atlas.texels().download()) area += double(texel.area);
    return area;
  };
  const SurfaceAtlas rebuilt(*test_device(), context.scheduler, context.scene, context.buffers, context.options,
                             "test");
  CHECK(sum(*context.atlas) == test::relative(sum(rebuilt), 1e-6));
}

TEST_CASE("a change of material is seen; one of its sides rebuilds") {
  AtlasContext context(make_builtin_scene("cornell"), 2000);
  SceneChange change;
  change.materials = {0};
  context.scene.materials[0].base_color = glm::vec4(0.25f, 0.5f, 0.75f, 1);
  context.scene.materials[0].ior = 1;
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == 1);
  const auto sides_of_material = [&] {
    const AtlasGeometry g = read_atlas_geometry(context.scene, context.buffers, false);
    const auto texels = context.atlas->texels().download();
    const auto materials = context.atlas->materials().download();
    uint32_t count = 0;
    for (size_t side = 0; side < texels.size(); ++side) {
      if (context.scene.instances[g.instance[texels[side].triangle]].material != 0) continue;
      CHECK(materials[side].diffuse.x == test::relative(0.25));
      CHECK(materials[side].diffuse.z == test::relative(0.75));
      ++count;
    }
    return count;
  };
  const uint32_t before = sides_of_material();
  CHECK(before > 0);
  CHECK(context.atlas->info().double_sided_count == 0);
  context.scene.materials[0].double_sided = true;
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == 2);
  CHECK(2 * context.atlas->info().double_sided_count == sides_of_material());
}

TEST_CASE("triangles that had no area get texels when they gain one") {
  Scene scene = make_builtin_scene("cornell");
  const size_t instance = scene.instances.size() - 1;
  const glm::mat4 whole = scene.instances[instance].world_from_object;
  scene.instances[instance].world_from_object = whole * glm::scale(glm::mat4(1), glm::vec3(0, 1, 1));
  AtlasContext context(scene, 4000);
  const uint64_t generation = context.atlas->generation();
  const glm::mat4 flat = context.scene.instances[instance].world_from_object;
  SceneChange change;
  change.moved_instances = {static_cast<int>(instance)};
  change.previous_world_from_object = {flat};
  context.scene.instances[instance].world_from_object = whole;
  context.buffers.update(context.scene, change);
  context.atlas->refit(context.scene, change);
  CHECK(context.atlas->generation() == generation + 1);
  check_follows(context);
}
