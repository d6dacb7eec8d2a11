// SPDX-License-Identifier: Apache-2.0
// Damaged, hostile and odd files: each is loaded or refused with one clear line, and none crashes or hangs.
#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "gltf_builder.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/gltf/import.h"
#include "lucarium/scene/image/environment_file.h"
#include "lucarium/scene/import_options.h"
#include "lucarium/scene/load/load_scene.h"
#include "test_support.h"

using namespace lucarium;
using test::GltfBuilder;

namespace {

/// The message with which the import of a file is refused; empty when it loads.
std::string refusal(const std::filesystem::path& file) {
  const std::string name = file.string();
  try {
    const bool environment = name.ends_with(".hdr") || name.ends_with(".exr");
    if (environment)
      load_environment(file);
    else
      load_scene(name);
    return "";
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    const std::string text = error.what();
    CHECK(text.starts_with(name + ": "));
    CHECK(text.size() > name.size() + 10);
    CHECK(std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }));
    return text;
  }
}

std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".gltf" || ending == ".glb" || ending == ".hdr" || ending == ".exr") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Message of a refusal of a document made here.
std::string refusal_of(const std::string& bytes, const ImportOptions& options = {}) {
  try {
    import_gltf_bytes(bytes, "/nonexistent", "test.gltf", options);
    return "";
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::input);
    return error.what();
  }
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Every invalid and every odd third-party file loads or is refused with one line") {
  const std::filesystem::path folder = test::shared_scenes();
  if (folder.empty()) return test::skip("third-party scenes");
  for (const char* part : {"invalid", "edge_valid"}) {
    for (const auto& file : files_below(folder / part)) {
      CAPTURE(file);
      refusal(file);
    }
  }
}

TEST_CASE("What glTF calls an error is refused with the right reason") {
  const std::filesystem::path folder = test::shared_scenes();
  if (folder.empty()) return test::skip("third-party scenes");
  const std::map<std::string, std::string> reasons = {
      {"assimp/IndexOutOfRange/IndexOutOfRange.gltf", "outside its 24 vertices"},
      {"assimp/RecursiveNodes/RecursiveNodes.gltf", "cycle"},
      {"assimp/IncorrectVertexArrays/Cube.gltf", "/bufferViews/2: 432 bytes"},
      {"assimp/wrongTypes/badObject.gltf", "must be an object"},
      {"assimp/wrongTypes/badUint.gltf", "baseColorTexture/index must be an integer"},
      {"gltf1/Box.glb", "glTF 1.0"},
      {"SharpGLTF/Invalid_Json.gltf", "malformed"},
      {"tinygltf/BoundsChecking/integer-out-of-bounds.gltf", "byteLength"},
      {"validator/base/glb/truncated_chunk_data.glb", "cut off"},
      {"validator/base/glb/chunk_too_big.glb", "cut off"},
      {"validator/base/accessor/small_stride.gltf", "stride"},
      {"validator/base/node/node_parent_override.gltf", "one parent"},
      {"validator/base/buffer/non_relative_uri.gltf", "'http:' URIs are not loaded"},
      {"validator/base/root/undefined_used_extensions.gltf", "requires the extension KHR_extension"},
      {"images/bomb.exr", "OpenEXR"},
  };
  for (const auto& [name, reason] : reasons) {
    CAPTURE(name);
    const std::string text = refusal(folder / "invalid" / name);
    CAPTURE(text);
    CHECK(contains(text, reason));
  }
}

TEST_CASE("Hostile images are refused or decoded, never fatal") {
  const std::filesystem::path folder = test::shared_scenes();
  if (folder.empty()) return test::skip("third-party scenes");
  for (const auto& entry : std::filesystem::directory_iterator(folder / "invalid/images")) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".jpg" && ending != ".png") continue;
    CAPTURE(entry.path());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    GltfBuilder builder = GltfBuilder::textured_triangle(bytes, "image/any");
    const std::string text = refusal_of(builder.text());
    if (contains(entry.path().string(), "bomb")) CHECK(contains(text, "65500x65500 pixels"));
  }
}

TEST_CASE("Node cycles, second parents and very deep hierarchies") {
  GltfBuilder builder = GltfBuilder::triangle();
  constexpr int depth = 200000;
  builder.json["nodes"] = nlohmann::json::array();
  for (int i = 0; i + 1 < depth; ++i) builder.json["nodes"].push_back({{"children", {i + 1}}});
  builder.json["nodes"].push_back({{"mesh", 0}});
  const Scene scene = import_gltf_bytes(builder.text(), ".", "deep.gltf");
  CHECK(scene.nodes.back().in_scene);
  CHECK(scene.instances.size() == 1);

  builder.json["nodes"] = {{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}};
  CHECK(contains(refusal_of(builder.text()), "one parent"));
  builder.json["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}};
  CHECK(contains(refusal_of(builder.text()), "cycle"));
}

TEST_CASE("Counts and offsets that would overflow") {
  for (const char* key : {"count", "byteOffset"}) {
    for (const double value : {4294967295.0, 4294967296.0, 9007199254740991.0, 1e18, 1.5, -1.0}) {
      GltfBuilder builder = GltfBuilder::triangle();
      builder.json["accessors"][0][key] = value;
      CAPTURE(key);
      CAPTURE(value);
      CHECK(contains(refusal_of(builder.text()), "/accessors/0"));
    }
  }
  for (const char* key : {"byteLength", "byteOffset"}) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["bufferViews"][0][key] = 9007199254740991.0;
    CHECK(contains(refusal_of(builder.text()), "/bufferViews/0"));
  }
}

TEST_CASE("Elements that exist only as a count are bounded") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["accessors"][0].erase("bufferView");
  builder.json["accessors"][0]["count"] = 9000000000000.0;
  CHECK(contains(refusal_of(builder.text()), "MiB"));
  // Many targets that share one accessor.
  builder = GltfBuilder::triangle();
  builder.json["accessors"][0].erase("bufferView");
  builder.json["accessors"][0]["count"] = 3000;
  for (int i = 0; i < 3000; ++i) builder.json["meshes"][0]["primitives"][0]["targets"].push_back({{"POSITION", 0}});
  ImportOptions options;
  options.max_triangles = 10000;
  CHECK(contains(refusal_of(builder.text(), options), "MiB"));
}

TEST_CASE("Positions that are not finite") {
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    GltfBuilder builder;
    builder.add_mesh(builder.add_floats({{0, 0, 0}, {1, bad, 0}, {0, 1, 0}}, "VEC3"));
    CHECK(contains(refusal_of(builder.text()), "element 1 of /accessors/0 is not finite"));
  }
}

TEST_CASE("Scenes without a triangle are refused with what to do") {
  test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "empty.gltf";
  for (const char* nodes : {"", R"({"name": "alone"})"}) {
    std::ofstream(file) << R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [)" << (*nodes ? "0" : "") << "]}]"
                        << (*nodes ? std::string(R"(, "nodes": [)") + nodes + "]" : "") << "}";
    CHECK(contains(refusal(file), "give a node of its default scene a mesh with triangles"));
  }
}

TEST_CASE("URIs that leave the folder") {
  test::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "scene/sub dir");
  std::ofstream(folder.path() / "secret.bin") << std::string(36, 'x');
  std::ofstream(folder.path() / "scene/sub dir/100%.bin") << std::string(36, '\0');
  const auto with_uri = [&](const std::string& uri) -> std::string {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["buffers"][0] = {{"byteLength", 36}, {"uri", uri}};
    try {
      import_gltf_bytes(builder.json.dump(), folder.path() / "scene", "test.gltf");
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  };
  const std::string secret = (folder.path() / "secret.bin").string();
  CHECK(contains(with_uri("../secret.bin"), "outside the folder"));
  CHECK(contains(with_uri("sub dir/../../secret.bin"), "outside the folder"));
  CHECK(contains(with_uri("%2e%2e/secret.bin"), "outside the folder"));
  CHECK(contains(with_uri(secret), "outside the folder"));
  CHECK(contains(with_uri("file://" + secret), "'file:' URIs are not loaded"));
  CHECK(contains(with_uri("https://example.com/a.bin"), "'https:' URIs are not loaded"));
  CHECK(contains(with_uri("sub dir"), "not a regular file"));
  CHECK(contains(with_uri("missing.bin"), "there is no file"));
  CHECK(contains(with_uri("data:application/octet-stream;base64,AA?A"), "not valid base64"));
  CHECK(contains(with_uri("data:application/octet-stream;base64,AAAA"), "3 bytes long, not 36"));
  CHECK(with_uri("sub%20dir/100%25.bin") == "");
  CHECK(with_uri("sub dir/100%.bin") == "");
  CHECK(with_uri("./sub dir/../sub dir/100%.bin") == "");
}

TEST_CASE("JSON that is nested too deeply") {
  const std::string text =
      R"({"asset":{"version":"2.0"},"extras":)" + std::string(100000, '[') + std::string(100000, ']') + "}";
  CHECK(contains(refusal_of(text), "levels deep"));
}

TEST_CASE("Messages stay one line, whatever the names") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["meshes"][0]["name"] = "a\nb\x1b[31m";
  builder.json["accessors"][0]["type"] = "VEC2";
  const std::string text = refusal_of(builder.text());
  CHECK(contains(text, "mesh 'a b"));
  CHECK(std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }));
}

TEST_CASE("Required extensions are refused by name with a remedy; optional looks are ignored") {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["extensionsRequired"] = builder.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  CHECK(contains(refusal_of(builder.text()), "KHR_draco_mesh_compression, which is not supported; export"));
  builder.json["extensionsRequired"] = {"ACME_thing"};
  CHECK(contains(refusal_of(builder.text()), "ACME_thing"));
  builder.json["extensionsRequired"] = {"KHR_materials_iridescence"};
  CHECK(refusal_of(builder.text()) == "");
}

TEST_CASE("Truncations of a small GLB never crash") {
  const std::string glb = GltfBuilder::triangle().glb();
  CHECK(refusal_of(glb) == "");
  for (size_t length = 0; length < glb.size(); ++length) {
    CAPTURE(length);
    CHECK(refusal_of(glb.substr(0, length)) != "");
  }
}

TEST_CASE("Environment maps with values that are no radiance") {
  test::TemporaryFolder folder;
  const auto file = folder.path() / "map.hdr";
  std::ofstream(file) << "plain text";
  CHECK(contains(refusal(file), "neither a Radiance .hdr nor an OpenEXR"));
  std::ofstream(file, std::ios::binary) << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40000 +X 40000\n";
  CHECK(contains(refusal(file), "40000x40000 pixels"));
  CHECK(contains(refusal(folder.path() / "missing.exr"), "no such file"));
}
