// SPDX-License-Identifier: Apache-2.0
// Geometry, lights, cameras and scene graph of glTF, each on a small file made here.
#include <doctest/doctest.h>

#include "gltf_builder.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/import_options.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::GltfBuilder;
using test::load;
using test::warns;
using Json = nlohmann::json;

TEST_CASE("A triangle without indices, normals and material") {
  const Scene scene = load(GltfBuilder::triangle());
  REQUIRE(scene.meshes.size() == 1);
  const Mesh& mesh = scene.meshes[0];
  CHECK(mesh.triangles == std::vector<glm::uvec3>{{0, 1, 2}});
  CHECK(mesh.flat_normals);
  for (const glm::vec3& normal : mesh.normals) CHECK(normal == glm::vec3(0, 0, 1));
  CHECK(scene.materials.at(mesh.material).base_color == glm::vec4(1));
  CHECK(scene.materials[mesh.material].metallic == 1.f);
  CHECK(warns(scene, "no material"));
}

TEST_CASE("The same document as a GLB") {
  const Scene scene = import_gltf_bytes(GltfBuilder::triangle().glb(), ".", "test.glb");
  CHECK(scene.triangle_count() == 1);
}

TEST_CASE("Indices of 8, 16 and 32 bits; flat normals split shared vertices") {
  for (int bits : {8, 16, 32}) {
    GltfBuilder builder;
    auto& primitive = builder.add_mesh(builder.add_floats({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, "VEC3"));
    primitive["indices"] = bits == 8    ? builder.add(std::vector<uint8_t>{0, 1, 2, 0, 3, 1}, "SCALAR")
                           : bits == 16 ? builder.add(std::vector<uint16_t>{0, 1, 2, 0, 3, 1}, "SCALAR")
                                        : builder.add(std::vector<uint32_t>{0, 1, 2, 0, 3, 1}, "SCALAR");
    const Scene scene = load(builder);
    const Mesh& mesh = scene.meshes.at(0);
    REQUIRE(mesh.positions.size() == 6);
    CHECK(mesh.normals[mesh.triangles[0].x] == glm::vec3(0, 0, 1));
    CHECK(mesh.normals[mesh.triangles[1].x] == glm::vec3(0, 1, 0));
  }
}

TEST_CASE("Strips keep their winding, fans share their first vertex, points and lines are dropped") {
  for (int mode = 0; mode <= 6; ++mode) {
    GltfBuilder builder;
    auto& primitive = builder.add_mesh(builder.add_floats({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, "VEC3"));
    primitive["mode"] = mode;
    CAPTURE(mode);
    const Scene scene = load(builder);
    if (mode < 4) {
      CHECK(scene.meshes.empty());
      CHECK(warns(scene, "points and lines"));
      continue;
    }
    CHECK(scene.triangle_count() == (mode == 4 ? 1 : 2));
    if (mode == 5) {
      for (const glm::vec3& normal : scene.meshes[0].normals) CHECK(normal.z == 1.f);
    }
    if (mode == 6) CHECK(scene.meshes[0].positions[scene.meshes[0].triangles[1].z] == glm::vec3(0));
  }
}

TEST_CASE("Interleaved attributes") {
  const std::vector<float> data = {0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 3, 0, 1, 0, 0, 0, 0};
  GltfBuilder builder;
  const int view = builder.add_view(data.data(), data.size() * sizeof(float), 24);
  auto& primitive = builder.add_mesh(builder.add_accessor(view, 5126, 3, "VEC3"));
  const int normals = builder.add_accessor(view, 5126, 3, "VEC3");
  builder.json["accessors"][normals]["byteOffset"] = 12;
  primitive["attributes"]["NORMAL"] = normals;
  const Scene scene = load(builder);
  CHECK(scene.meshes.at(0).positions[2] == glm::vec3(0, 1, 0));
  CHECK(scene.meshes[0].normals[0] == glm::vec3(0, 0, 1));  // unit length
  CHECK(scene.meshes[0].normals[2] == glm::vec3(0, 0, 1));  // made from the triangle
  CHECK(warns(scene, "1 normals of length 0"));
}

TEST_CASE("Sparse accessors with and without a buffer view") {
  for (bool with_view : {true, false}) {
    GltfBuilder builder = GltfBuilder::triangle();
    const std::vector<uint16_t> indices = {2};
    const std::vector<float> values = {5, 6, 7};
    builder.json["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", builder.add_view(indices.data(), 2)}, {"componentType", 5123}}},
        {"values", {{"bufferView", builder.add_view(values.data(), 12)}}}};
    if (!with_view) builder.json["accessors"][0].erase("bufferView");
    const Scene scene = load(builder);
    CHECK(scene.meshes.at(0).positions[2] == glm::vec3(5, 6, 7));
    CHECK(scene.meshes[0].positions[1] == (with_view ? glm::vec3(1, 0, 0) : glm::vec3(0)));
  }
}

TEST_CASE("KHR_mesh_quantization: normalized and plain integers") {
  GltfBuilder builder;
  const std::vector<int16_t> positions = {0, 0, 0, 32767, 0, 0, 0, -32768, 0};
  auto& primitive = builder.add_mesh(builder.add(positions, "VEC3", true));
  const std::vector<int8_t> normals = {0, 0, 127, 0, 0, 127, 0, 0, 127};
  primitive["attributes"]["NORMAL"] = builder.add(normals, "VEC3", true);
  primitive["attributes"]["TEXCOORD_0"] = builder.add(std::vector<uint8_t>{0, 0, 3, 0, 0, 7}, "VEC2");
  builder.json["extensionsUsed"] = builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Scene scene = load(builder);
  CHECK(scene.meshes.at(0).positions[1] == glm::vec3(1, 0, 0));
  CHECK(scene.meshes[0].positions[2] == glm::vec3(0, -1, 0));
  CHECK(scene.meshes[0].normals[0] == glm::vec3(0, 0, 1));
  CHECK(scene.meshes[0].uv[0][2] == glm::vec2(0, 7));
}

TEST_CASE("Vertex colours of all forms") {
  GltfBuilder builder = GltfBuilder::triangle();
  auto& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["COLOR_0"] = builder.add_floats({{1, 0, 0}, {0, 1, 0}, {0, 0, 2}}, "VEC3");
  CHECK(load(builder).meshes.at(0).colors[2] == glm::vec4(0, 0, 1, 1));
  attributes["COLOR_0"] = builder.add(std::vector<uint8_t>{255, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", true);
  CHECK(load(builder).meshes.at(0).colors[0].a == test::relative(0.2));
  attributes["COLOR_0"] = builder.add(std::vector<uint16_t>{65535, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", true);
  CHECK(load(builder).meshes.at(0).colors[0] == glm::vec4(1, 0, 0, 1));
}

TEST_CASE("Punctual lights: types, units, cones, placement by nodes") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 20}, {"name", "bulb"}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}}},
      {{"type", "directional"}, {"intensity", 3}},
      {{"type", "laser"}}};
  for (int i = 0; i < 4; ++i) {
    builder.append("nodes", {{"translation", {i, 0, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    builder.json["scenes"][0]["nodes"].push_back(i + 1);
  }
  Scene scene = load(builder);
  REQUIRE(scene.lights.size() == 3);
  CHECK(scene.lights[0].name == "bulb");
  CHECK(scene.lights[0].intensity == glm::vec3(20, 10, 0));
  CHECK(scene.lights[1].type == LightType::spot);
  CHECK(scene.lights[1].inner_angle == 0.1f);
  CHECK(scene.lights[1].outer_angle == 0.5f);
  CHECK(scene.lights[2].type == LightType::directional);
  CHECK(scene.lights[2].intensity == glm::vec3(3));
  CHECK(warns(scene, "'laser' is unknown"));
  evaluate(scene, 0);
  CHECK(scene.lights[1].world_from_light[3].x == 1.f);
}

TEST_CASE("Cameras of both kinds") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.1}, {"aspectRatio", 1.5}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", -3}, {"znear", 0}, {"zfar", 1}}}}};
  builder.json["nodes"][0]["camera"] = 0;
  builder.json["nodes"][0]["children"] = {1};
  builder.append("nodes", {{"camera", 1}});
  const Scene scene = load(builder);
  REQUIRE(scene.cameras.size() == 2);
  CHECK(scene.cameras[0].yfov == 0.9f);
  CHECK(scene.cameras[0].aspect == 1.5f);
  CHECK_FALSE(scene.cameras[1].perspective);
  CHECK(scene.cameras[1].ymag == 3.f);
  builder.json["cameras"][1]["orthographic"]["xmag"] = 0;
  CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("must not be 0"), Error);
}

TEST_CASE("Nodes: hierarchy, matrices, quaternions, negative scale, several scenes") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["nodes"] = {{{"children", {1}}, {"scale", {-2, 2, 2}}, {"rotation", {0, 0, 2, 0}}},
                           {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}}},
                           {{"mesh", 0}}};
  builder.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {2}}}};
  Scene scene = load(builder);
  CHECK(warns(scene, "2 scenes: scene 0"));
  REQUIRE(scene.instances.size() == 1);
  CHECK(scene.instances[0].node == 1);
  CHECK_FALSE(scene.nodes[2].in_scene);
  evaluate(scene, 0);
  const glm::mat4& m = scene.instances[0].world_from_object;
  CHECK(glm::determinant(glm::mat3(m)) == test::relative(-8));
  CHECK(test::largest_difference(glm::vec3(m[3]), {10, 0, 0}) < 1e-5f);  // -2 · 5, turned by 180° about z
  ImportOptions options;
  options.gltf_scene = 1;
  CHECK(load(builder, options).instances.at(0).node == 2);
  options.gltf_scene = 2;
  CHECK_THROWS_WITH_AS(load(builder, options), doctest::Contains("there is no scene 2"), Error);
}

TEST_CASE("EXT_mesh_gpu_instancing makes one node per instance") {
  GltfBuilder builder = GltfBuilder::triangle();
  const int translations = builder.add_floats({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, "VEC3");
  const int rotations = builder.add(std::vector<int8_t>{0, 0, 0, 127, 0, 0, 127, 0, 0, 0, 0, 127}, "VEC4", true);
  builder.json["nodes"][0]["scale"] = {2, 2, 2};
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", translations},
                                                                                     {"ROTATION", rotations}};
  Scene scene = load(builder);
  REQUIRE(scene.instances.size() == 3);
  evaluate(scene, 0);
  CHECK(scene.instances[2].world_from_object[3].x == 6.f);
  CHECK(scene.instances[1].world_from_object[0].x == test::relative(-2));
  ImportOptions options;
  options.max_triangles = 2;
  CHECK_THROWS_WITH_AS(load(builder, options), doctest::Contains("more than 2 triangles"), Error);
}

TEST_CASE("Extensions are reported as used and as ignored") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_ior", "ACME_notes"};
  builder.json["meshes"][0]["primitives"][0]["material"] = 0;
  builder.append("materials", {{"extensions",
                                {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}},
                                 {"KHR_materials_ior", {{"ior", 1.4}}},
                                 {"KHR_materials_sheen", Json::object()}}}});
  const Scene scene = load(builder);
  CHECK(scene.extensions_used.size() == 4);
  CHECK(scene.extensions_ignored ==
        std::vector<std::string>{"ACME_notes", "KHR_materials_clearcoat", "KHR_materials_sheen"});
  CHECK(warns(scene, "KHR_materials_sheen is used but not listed"));
  CHECK(std::count_if(scene.warnings.begin(), scene.warnings.end(), [](const std::string& text) {
          return text.find("KHR_materials_clearcoat") != std::string::npos;
        }) == 1);
}

TEST_CASE("a 2x2 matrix of bytes whose last column is not padded was refused") {
  for (const auto& [type, component, bytes] :
       {std::tuple("MAT2", 5121, 14u), {"MAT3", 5121, 23u}, {"MAT3", 5122, 46u}}) {
    for (const size_t missing : {0, 1}) {
      GltfBuilder builder = GltfBuilder::triangle();
      const std::string zeros(bytes, '\0');
      builder.add_accessor(builder.add_view(zeros.data(), bytes - missing), component, 2, type);
      if (missing) {
        CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("reach beyond"), Error);
      } else {
        CHECK(load(builder).triangle_count() == 1);
      }
    }
  }
}
