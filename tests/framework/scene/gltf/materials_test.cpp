// SPDX-License-Identifier: Apache-2.0
// Materials, textures and images of glTF, each on a small file made here.
#include <doctest/doctest.h>

#include "gltf_builder.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/import_options.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;
using test::GltfBuilder;
using test::load;
using test::warns;
using Json = nlohmann::json;

namespace {

SceneMaterial material_of(const Json& material) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.append("materials", material);
  builder.json["meshes"][0]["primitives"][0]["material"] = 0;
  return load(builder).materials.at(0);
}

/// A 2×1 PNG: red and, half transparent, green.
std::string png_2x1() {
  static const uint8_t bytes[] = {
      0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
      0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00, 0x00, 0xF4, 0x22, 0x7F, 0x8A, 0x00, 0x00, 0x00,
      0x0F, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9C, 0x63, 0xF8, 0xCF, 0xC0, 0xF0, 0x1F, 0x08, 0x1B, 0x00, 0x10, 0x79,
      0x03, 0x7E, 0x7D, 0x63, 0xCE, 0xD7, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82};
  return {reinterpret_cast<const char*>(bytes), sizeof(bytes)};
}

}  // namespace

TEST_CASE("Textures: alpha stays unassociated, uses as colour and as data, samplers, transform") {
  GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  builder.json["textures"][0]["sampler"] = 0;
  auto& material = builder.json["materials"][0];
  material["emissiveTexture"] = {{"index", 0}};
  material["normalTexture"] = {{"index", 0}, {"scale", 0.5}};
  material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.25, 0.5}}, {"scale", {2, 3}}, {"rotation", 1.5}, {"texCoord", 0}};
  const Scene scene = load(builder);
  REQUIRE(scene.images.size() == 1);
  CHECK(scene.images[0].rgba == std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 128});
  REQUIRE(scene.textures.size() == 2);
  const TextureUse& base = scene.materials[0].base_color_texture;
  CHECK(scene.textures[base.texture].srgb);
  CHECK_FALSE(scene.textures[scene.materials[0].normal_texture.texture].srgb);
  CHECK(scene.materials[0].emissive_texture.texture == base.texture);
  CHECK(scene.textures[base.texture].wrap_u == Wrap::clamp);
  CHECK(scene.textures[base.texture].wrap_v == Wrap::mirror);
  CHECK(scene.textures[base.texture].nearest);
  CHECK(base.uv_set == 0);
  CHECK(base.offset == glm::vec2(0.25f, 0.5f));
  CHECK(base.scale == glm::vec2(2, 3));
  CHECK(base.rotation == 1.5f);
  CHECK(scene.materials[0].normal_texture.strength == 0.5f);
  // Texture coordinates (x, -y): t along +x; up in the image is +y, so the frame is not mirrored.
  for (const glm::vec4& tangent : scene.meshes[0].tangents) CHECK(tangent == glm::vec4(1, 0, 0, 1));
}

TEST_CASE("Mirrored texture coordinates flip the tangent's handedness and split vertices") {
  GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  auto& primitive = builder.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] = builder.add_floats({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}}, "VEC3");
  primitive["attributes"]["NORMAL"] = builder.add_floats({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, "VEC3");
  primitive["attributes"]["TEXCOORD_0"] = builder.add_floats({{0, 0}, {0, -1}, {1, 0}, {1, 0}}, "VEC2");
  primitive["indices"] = builder.add(std::vector<uint8_t>{0, 2, 1, 0, 1, 3}, "SCALAR");
  builder.json["materials"][0]["normalTexture"] = {{"index", 0}};
  const Scene scene = load(builder);
  const Mesh& mesh = scene.meshes.at(0);
  CHECK(mesh.positions.size() == 6);
  for (int i = 0; i < 3; ++i) {
    CHECK(mesh.tangents[mesh.triangles[0][i]] == glm::vec4(1, 0, 0, 1));
    CHECK(mesh.tangents[mesh.triangles[1][i]] == glm::vec4(-1, 0, 0, -1));
  }
}

TEST_CASE("Texture coordinates that are not there") {
  GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  CHECK(warns(load(builder), "lacks TEXCOORD_1"));
  builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 3;
  const Scene scene = load(builder);
  CHECK(warns(scene, "TEXCOORD_3"));
  CHECK(scene.materials[0].base_color_texture.uv_set == 0);
}

TEST_CASE("Occlusion textures that are left out are warned of") {
  GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  CHECK_FALSE(warns(load(builder), "occlusion"));
  builder.json["materials"][0]["occlusionTexture"] = {{"index", 0}};
  CHECK(warns(load(builder), "occlusion textures are ignored"));
}

TEST_CASE("Images that are missing, of another kind, or too large") {
  GltfBuilder builder = GltfBuilder::textured_triangle("RIFF\1\1\1\1WEBP", "image/webp");
  CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("is a WebP image"), Error);
  builder = GltfBuilder::textured_triangle(png_2x1().substr(0, 50), "image/png");
  CHECK_THROWS_WITH_AS(load(builder), doctest::Contains("damaged PNG"), Error);
  builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  ImportOptions options;
  options.max_image_pixels = 1;
  CHECK_THROWS_WITH_AS(load(builder, options), doctest::Contains("2x1 pixels, more than the 1"), Error);
  options = {};
  options.max_texture_size = 1;
  const Scene scene = load(builder, options);
  CHECK(scene.images.at(0).rgba == std::vector<uint8_t>{128, 128, 0, 192});
  CHECK(warns(scene, "scaled down to 1x1"));
  builder.json["textures"][0] = Json::object();
  CHECK(load(builder).materials[0].base_color_texture.texture == none);
}

TEST_CASE("PNGs of 1 bit, with a palette, and of 16 bits with grey and alpha") {
  const auto pixels = [](const char* base64) {
    GltfBuilder builder = GltfBuilder::textured_triangle("x", "image/png");
    builder.json["images"][0] = {{"uri", std::string("data:image/png;base64,") + base64}};
    return load(builder).images.at(0).rgba;
  };
  CHECK(pixels("iVBORw0KGgoAAAANSUhEUgAAAAIAAAABAQAAAADcWUInAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg"
               "==") == std::vector<uint8_t>{255, 255, 255, 255, 0, 0, 0, 255});
  CHECK(pixels("iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAMAAADD/I+4AAAABlBMVEUKFB4oMjzVG7TpAAAAAnRSTlP/ZK9olQsAAA"
               "ADdEVYdGEAYtxJojsAAAALSURBVHicY2BkAAAABQAC0WYzeAAAAABJRU5ErkJggg==") ==
        std::vector<uint8_t>{40, 50, 60, 100, 10, 20, 30, 255});
  CHECK(pixels("iVBORw0KGgoAAAANSUhEUgAAAAIAAAABEAQAAAAOu2tCAAAABGdBTUEAAYagMeiWXwAAABFJREFUeJxj+P+/oUFE5P"
               "9/ABgDBSXQzxwtAAAAAElFTkSuQmCC") == std::vector<uint8_t>{255, 255, 255, 128, 20, 20, 20, 255});
}

TEST_CASE("WebP and Basis textures fall back to their plain image, or are refused where required") {
  for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu"}) {
    GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
    builder.json["textures"][0]["extensions"][name] = {{"source", 0}};
    builder.json["extensionsUsed"] = {name};
    CHECK(load(builder).materials[0].base_color_texture.texture == 0);
    builder.json["textures"][0].erase("source");
    CHECK(warns(load(builder), name));
    builder.json["extensionsRequired"] = {name};
    CHECK_THROWS_WITH_AS(load(builder), doctest::Contains(name), Error);
  }
}

TEST_CASE("Material factors and their extensions") {
  const SceneMaterial plain =
      material_of({{"name", "m"},
                   {"pbrMetallicRoughness",
                    {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 2}}},
                   {"emissiveFactor", {10, 0, 0}},
                   {"alphaMode", "MASK"},
                   {"alphaCutoff", 0.25},
                   {"doubleSided", true}});
  CHECK(plain.name == "m");
  CHECK(plain.base_color == glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  CHECK(plain.metallic == 0.5f);
  CHECK(plain.roughness == 1.f);
  CHECK(plain.emissive_factor == glm::vec3(10, 0, 0));
  CHECK(plain.alpha_mode == AlphaMode::mask);
  CHECK(plain.alpha_cutoff == 0.25f);
  CHECK(plain.double_sided);

  const SceneMaterial glass =
      material_of({{"alphaMode", "BLEND"},
                   {"extensions",
                    {{"KHR_materials_ior", {{"ior", 1.33}}},
                     {"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
                     {"KHR_materials_volume",
                      {{"thicknessFactor", 2}, {"attenuationDistance", 3}, {"attenuationColor", {0.5, 0.6, 0.7}}}},
                     {"KHR_materials_emissive_strength", {{"emissiveStrength", 50}}}}}});
  CHECK(glass.alpha_mode == AlphaMode::blend);
  CHECK(glass.ior == 1.33f);
  CHECK(glass.transmission == 0.75f);
  CHECK(glass.thickness == 2.f);
  CHECK(glass.attenuation_distance == 3.f);
  CHECK(glass.attenuation_color == glm::vec3(0.5f, 0.6f, 0.7f));
  CHECK(glass.emissive_strength == 50.f);
  CHECK(material_of({{"extensions", {{"KHR_materials_unlit", Json::object()}}}}).unlit);
}

TEST_CASE("Specular-glossiness becomes metallic-roughness") {
  const auto convert = [](const Json& values) {
    return material_of({{"extensions", {{"KHR_materials_pbrSpecularGlossiness", values}}}});
  };
  const SceneMaterial plastic = convert(
      {{"diffuseFactor", {0.5, 0.25, 0.1, 1}}, {"specularFactor", {0.04, 0.04, 0.04}}, {"glossinessFactor", 0.25}});
  CHECK(plastic.metallic == test::within(0, 1e-3));
  CHECK(test::largest_difference(glm::vec3(plastic.base_color), {0.5f, 0.25f, 0.1f}) < 1e-3f);
  CHECK(plastic.roughness == 0.75f);
  const SceneMaterial gold = convert({{"diffuseFactor", {0, 0, 0, 0.5}}, {"specularFactor", {1, 0.76, 0.33}}});
  CHECK(gold.metallic == test::relative(1));
  CHECK(test::largest_difference(glm::vec3(gold.base_color), {1, 0.76f, 0.33f}) < 1e-3f);
  CHECK(gold.base_color.a == 0.5f);
  CHECK(gold.roughness == 0.f);

  GltfBuilder builder = GltfBuilder::textured_triangle(png_2x1(), "image/png");
  builder.json["materials"][0] = {
      {"extensions",
       {{"KHR_materials_pbrSpecularGlossiness",
         {{"diffuseFactor", {0, 0, 0, 1}}, {"specularGlossinessTexture", {{"index", 0}}}}}}}};
  const Scene scene = load(builder);
  const SceneMaterial& textured = scene.materials[0];
  const Image& base = scene.images[scene.textures[textured.base_color_texture.texture].image];
  const Image& other = scene.images[scene.textures[textured.metallic_roughness_texture.texture].image];
  CHECK(base.rgba[0] == 255);              // red mirror
  CHECK(int(other.rgba[2]) == 255);        // metallic
  CHECK(int(other.rgba[1]) == 0);          // glossiness 1
  CHECK(int(other.rgba[5]) == 255 - 128);  // glossiness 128/255
}
