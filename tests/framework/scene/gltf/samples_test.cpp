// SPDX-License-Identifier: Apache-2.0
// The third-party scenes load, or are refused for a stated reason, with the triangle counts of their catalogue.
#include <doctest/doctest.h>

#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/image/environment_file.h"
#include "test_support.h"

using namespace lucarium;

namespace {

/// Files that need a decoder or an image format that is not supported, with what the message must name.
const std::map<std::string, std::string> refused = {
    {"compressed/apartment_dream_house_meshopt.glb", "EXT_meshopt_compression"},
    {"compressed/BoxMeshopt.glb", "EXT_meshopt_compression"},
    {"compressed/BoxDraco/BoxDraco.gltf", "KHR_draco_mesh_compression"},
    {"compressed/RiggedSimple-Draco/RiggedSimple.gltf", "KHR_draco_mesh_compression"},
    {"compressed/AnisotropyBarnLamp-KTX2-Basisu/AnisotropyBarnLamp.gltf", "KTX2"},
};

nlohmann::json catalogue(const std::filesystem::path& folder) {
  std::ifstream file(folder / "scenes.json");
  return nlohmann::json::parse(file).at("scenes");
}

void check_refusal(const std::filesystem::path& file, const std::string& reason) {
  try {
    import_gltf(file);
    FAIL("it should have been refused");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    CHECK(std::string(error.what()).find(reason) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("Third-party scenes load with the triangles, lights and animations of their catalogue") {
  const std::filesystem::path folder = test::shared_scenes();
  if (folder.empty()) return test::skip("third-party scenes");
  for (const auto& entry : catalogue(folder)) {
    const std::string path = entry.at("path");
    if (path.starts_with("env/")) continue;
    CAPTURE(path);
    if (const auto found = refused.find(path); found != refused.end()) {
      check_refusal(folder / path, found->second);
      continue;
    }
    const Scene scene = import_gltf(folder / path);
    CHECK(scene.triangle_count() == entry.at("triangles").get<uint64_t>());
    CHECK(scene.animations.size() == entry.at("animations").get<size_t>());
    CHECK(scene.skins.size() == entry.at("skins").get<size_t>());
    CHECK(scene.lights.size() == entry.at("light_nodes").get<size_t>());
    for (const Mesh& mesh : scene.meshes) {
      CHECK(mesh.normals.size() == mesh.positions.size());
      if (scene.materials[mesh.material].normal_texture.texture != none)
        CHECK(mesh.tangents.size() == mesh.positions.size());
    }
  }
}

TEST_CASE("Environment maps load") {
  const std::filesystem::path folder = test::shared_scenes();
  if (folder.empty()) return test::skip("third-party scenes");
  for (const char* name : {"env/venice_sunset_1k.hdr", "env/sepulchral_chapel_rotunda_1k.hdr", "env/sunsky.exr"}) {
    const Environment environment = load_environment(folder / name);
    CHECK(environment.radiance.size() == size_t(environment.width) * environment.height);
    CHECK(environment.width >= 1024);
  }
}
