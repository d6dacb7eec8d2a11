// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/export.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <set>
#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/film/image_stream.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr int component_float = 5126, component_uint = 5125;  // glTF's numbers
constexpr uint64_t largest_glb = UINT32_MAX;

template <class V>
Json array_of(const V& v) {
  Json array = Json::array();
  for (int i = 0; i < V::length(); ++i) array.push_back(v[i]);
  return array;
}

Json matrix(const glm::mat4& m) { return std::vector<float>(glm::value_ptr(m), glm::value_ptr(m) + 16); }

std::string encode_png(const Image& image) {
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 4, OIIO::TypeDesc::UINT8);
  spec.alpha_channel = 3;
  spec.attribute("oiio:UnassociatedAlpha", 1);  // else colours under alpha 0 are lost
  std::vector<unsigned char> encoded;
  OIIO::Filesystem::IOVecOutput memory(encoded);
  const auto out = OIIO::ImageOutput::create("png");
  if (!out || !out->set_ioproxy(&memory) || !out->open("memory.png", spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, image.rgba.data()) || !out->close()) {
    throw_error(ErrorClass::internal, "cannot encode the image '{}': {}", image.name,
                out ? out->geterror() : OIIO::geterror());
  }
  return {encoded.begin(), encoded.end()};
}

/// Splits a colour into glTF's pair of a factor in 0 … 1 and a strength.
std::pair<glm::vec3, float> split_strength(const glm::vec3& color, float strength) {
  const float largest = std::max({color.r, color.g, color.b});
  return largest > 1 ? std::pair(color / largest, strength * largest) : std::pair(color, strength);
}

/// Builds the JSON and the one buffer of a .glb.
class GlbWriter {
 public:
  explicit GlbWriter(const Scene& scene) : scene_(scene) {}

  std::string write(const std::string& shown_name) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Lucarium " LUCARIUM_VERSION}};
    json_["scene"] = 0;
    json_["scenes"] = {{{"nodes", Json::array()}}};
    for (const Image& image : scene_.images) write_image(image);
    for (const SceneTexture& texture : scene_.textures) write_texture(texture);
    for (const SceneMaterial& material : scene_.materials) append("materials", material_json(material));
    for (const SceneInstance& instance : scene_.instances) write_instance(instance);
    for (const SceneLight& light : scene_.lights) write_light(light);
    for (const SceneCamera& camera : scene_.cameras) write_camera(camera);
    if (!extensions_.empty()) json_["extensionsUsed"] = extensions_;
    return container(shown_name);
  }

 private:
  int append(const char* section, Json element) {
    json_[section].push_back(std::move(element));
    return static_cast<int>(json_[section].size()) - 1;
  }

  void add_node(Json node) { json_["scenes"][0]["nodes"].push_back(append("nodes", std::move(node))); }

  int add_view(const void* data, size_t bytes) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    const int view = append("bufferViews", {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes}});
    buffer_.append(static_cast<const char*>(data), bytes);
    return view;
  }

  template <class V>
  int add_accessor(const std::vector<V>& values, const char* type, int component = component_float) {
    const int view = add_view(values.data(), values.size() * sizeof(V));
    return append("accessors",
                  {{"bufferView", view}, {"componentType", component}, {"count", values.size()}, {"type", type}});
  }

  Json& extension(Json& owner, const char* name) {
    extensions_.insert(name);
    return owner["extensions"][name];
  }

  void write_image(const Image& image) {
    const std::string png = encode_png(image);
    append("images",
           {{"name", image.name}, {"mimeType", "image/png"}, {"bufferView", add_view(png.data(), png.size())}});
  }

  void write_texture(const SceneTexture& texture) {
    const auto wrap = [](Wrap w) { return w == Wrap::clamp ? 33071 : w == Wrap::mirror ? 33648 : 10497; };
    const int filter = texture.nearest ? 9728 : 9729;
    const int sampler = append("samplers", {{"wrapS", wrap(texture.wrap_u)},
                                            {"wrapT", wrap(texture.wrap_v)},
                                            {"magFilter", filter},
                                            {"minFilter", filter}});
    append("textures", {{"source", texture.image}, {"sampler", sampler}});
  }

  void add_texture_use(Json& owner, const char* key, const TextureUse& use) {
    if (use.texture == none) return;
    Json& info = owner[key] = {{"index", use.texture}, {"texCoord", use.uv_set}};
    if (use.offset == glm::vec2(0) && use.scale == glm::vec2(1) && use.rotation == 0) return;
    extension(info, "KHR_texture_transform") = {
        {"offset", array_of(use.offset)}, {"scale", array_of(use.scale)}, {"rotation", use.rotation}};
  }

  Json material_json(const SceneMaterial& m) {
    Json json = {{"name", m.name}, {"doubleSided", m.double_sided}};
    Json& pbr = json["pbrMetallicRoughness"] = {
        {"baseColorFactor", array_of(m.base_color)}, {"metallicFactor", m.metallic}, {"roughnessFactor", m.roughness}};
    add_texture_use(pbr, "baseColorTexture", m.base_color_texture);
    add_texture_use(pbr, "metallicRoughnessTexture", m.metallic_roughness_texture);
    add_texture_use(json, "normalTexture", m.normal_texture);
    if (m.normal_texture.texture != none) json["normalTexture"]["scale"] = m.normal_texture.strength;
    add_texture_use(json, "emissiveTexture", m.emissive_texture);
    const auto [factor, strength] = split_strength(m.emissive_factor, m.emissive_strength);
    json["emissiveFactor"] = array_of(factor);
    if (strength != 1) extension(json, "KHR_materials_emissive_strength") = {{"emissiveStrength", strength}};
    if (m.alpha_mode == AlphaMode::blend) json["alphaMode"] = "BLEND";
    if (m.alpha_mode == AlphaMode::mask) json["alphaMode"] = "MASK", json["alphaCutoff"] = m.alpha_cutoff;
    if (m.unlit) extension(json, "KHR_materials_unlit") = Json::object();
    if (m.ior != 1.5f) extension(json, "KHR_materials_ior") = {{"ior", m.ior}};
    if (m.transmission > 0) {
      Json& transmission = extension(json, "KHR_materials_transmission") = {{"transmissionFactor", m.transmission}};
      add_texture_use(transmission, "transmissionTexture", m.transmission_texture);
    }
    if (m.thickness > 0) {
      Json& volume = extension(json, "KHR_materials_volume") = {{"thicknessFactor", m.thickness},
                                                                {"attenuationColor", array_of(m.attenuation_color)}};
      if (std::isfinite(m.attenuation_distance)) volume["attenuationDistance"] = m.attenuation_distance;
    }
    return json;
  }

  Json attributes(const Mesh& mesh) {
    Json json;
    json["POSITION"] = add_accessor(mesh.positions, "VEC3");
    Bounds bounds;
    for (const glm::vec3& p : mesh.positions) bounds.add(p);
    json_["accessors"].back()["min"] = array_of(bounds.min);
    json_["accessors"].back()["max"] = array_of(bounds.max);
    if (!mesh.normals.empty()) json["NORMAL"] = add_accessor(mesh.normals, "VEC3");
    if (!mesh.tangents.empty()) json["TANGENT"] = add_accessor(mesh.tangents, "VEC4");
    if (!mesh.uv[0].empty()) json["TEXCOORD_0"] = add_accessor(mesh.uv[0], "VEC2");
    if (!mesh.uv[1].empty()) json["TEXCOORD_1"] = add_accessor(mesh.uv[1], "VEC2");
    if (!mesh.colors.empty()) json["COLOR_0"] = add_accessor(mesh.colors, "VEC4");
    return json;
  }

  int write_mesh(const Mesh& mesh, int material, bool mirrored) {
    std::vector<glm::uvec3> triangles = mesh.triangles;
    if (mirrored) {
      for (glm::uvec3& t : triangles) std::swap(t.y, t.z);
    }
    const Json attribute_accessors = attributes(mesh);
    const int view = add_view(triangles.data(), triangles.size() * sizeof(glm::uvec3));
    const int indices = append(
        "accessors",
        {{"bufferView", view}, {"componentType", component_uint}, {"count", 3 * triangles.size()}, {"type", "SCALAR"}});
    const Json primitive = {{"attributes", attribute_accessors}, {"indices", indices}, {"material", material}};
    return append("meshes", {{"name", mesh.name}, {"primitives", Json::array({primitive})}});
  }

  void write_instance(const SceneInstance& instance) {
    const Mesh& shape = instance.shape(scene_);
    if (shape.triangles.empty()) return;
    const std::tuple key(&shape, instance.material, instance.mirrored);
    auto found = meshes_.find(key);
    if (found == meshes_.end())
      found = meshes_.emplace(key, write_mesh(shape, instance.material, instance.mirrored)).first;
    Json node = {{"name", shape.name}, {"mesh", found->second}};
    if (instance.world_from_object != glm::mat4(1.f)) node["matrix"] = matrix(instance.world_from_object);
    add_node(std::move(node));
  }

  void write_light(const SceneLight& light) {
    const char* types[] = {"point", "spot", "directional"};
    const auto [color, intensity] = split_strength(light.intensity, 1.f);
    Json json = {{"name", light.name},
                 {"type", types[static_cast<int>(light.type)]},
                 {"color", array_of(color)},
                 {"intensity", intensity}};
    if (light.type == LightType::spot) {
      json["spot"] = {{"innerConeAngle", light.inner_angle}, {"outerConeAngle", light.outer_angle}};
    }
    Json& list = extension(json_, "KHR_lights_punctual")["lights"];
    list.push_back(std::move(json));
    Json node = {{"name", light.name}, {"matrix", matrix(light.world_from_light)}};
    node["extensions"]["KHR_lights_punctual"]["light"] = list.size() - 1;
    add_node(std::move(node));
  }

  void write_camera(const SceneCamera& camera) {
    // glTF demands clipping planes, which path tracing has no use for.
    Json json = {{"name", camera.name}, {"type", camera.perspective ? "perspective" : "orthographic"}};
    if (camera.perspective) {
      json["perspective"] = {{"yfov", camera.yfov}, {"znear", 0.01}};
      if (camera.aspect > 0) json["perspective"]["aspectRatio"] = camera.aspect;
    } else {
      json["orthographic"] = {{"xmag", camera.xmag}, {"ymag", camera.ymag}, {"znear", 0}, {"zfar", 1e6}};
    }
    add_node({{"name", camera.name},
              {"camera", append("cameras", std::move(json))},
              {"matrix", matrix(camera.world_from_camera)}});
  }

  /// Header and the two chunks, glTF 2.0, section 4.4.
  std::string container(const std::string& shown_name) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    json_["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string text = json_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const uint64_t total = 12 + 8 + text.size() + 8 + buffer_.size();
    if (total > largest_glb) throw_error(ErrorClass::input, "{}: a .glb cannot be larger than 4 GiB", shown_name);
    std::string glb = "glTF";
    const auto put = [&glb](uint64_t value) {
      for (int shift = 0; shift < 32; shift += 8) glb.push_back(static_cast<char>(value >> shift & 255));
    };
    put(2), put(total), put(text.size());
    glb += "JSON" + text;
    put(buffer_.size());
    glb.append("BIN\0", 4);
    return glb + buffer_;
  }

  const Scene& scene_;
  Json json_;
  std::string buffer_;
  std::set<std::string> extensions_;
  std::map<std::tuple<const Mesh*, int, bool>, int> meshes_;
};

fs::path beside(const fs::path& file, const char* ending) { return file.string() + ending; }

/// The picture with its factor in it, so that only the turn is left to say.
void write_environment(const Environment& environment, const fs::path& file) {
  std::vector<glm::vec3> radiance = environment.radiance;
  for (glm::vec3& value : radiance) value *= environment.factor;
  OIIO::ImageSpec spec(static_cast<int>(environment.width), static_cast<int>(environment.height), 3,
                       OIIO::TypeDesc::FLOAT);
  spec.attribute("compression", "zip");
  write_image_file(file, spec, OIIO::TypeDesc::FLOAT, radiance.data());
}

bool has_picture(const Scene& scene) { return scene.environment && scene.environment->width > 0; }

Json sidecar_json(const Scene& scene, const fs::path& picture) {
  Json json = {{"exposure", is_automatic(scene.exposure) ? Json("auto") : Json(scene.exposure)}};
  if (!scene.environment) return json;
  if (!has_picture(scene)) {
    json["environment"]["radiance"] = array_of(scene.environment->factor);
  } else {
    // environment_from_world turns about Y by minus the picture's angle.
    const glm::mat3& m = scene.environment->environment_from_world;
    json["environment"] = {{"file", picture.filename().string()},
                           {"rotation_degrees", glm::degrees(-std::atan2(m[2][0], m[0][0]))}};
  }
  return json;
}

}  // namespace

std::vector<fs::path> exported_files(const Scene& scene, const fs::path& file) {
  std::vector<fs::path> files = {file, beside(file, ".lucarium.json")};
  if (has_picture(scene)) files.push_back(beside(file, ".environment.exr"));
  return files;
}

void export_gltf(const Scene& scene, const fs::path& file) {
  write_file_atomically(file, GlbWriter(scene).write(file.string()));
  const fs::path picture = beside(file, ".environment.exr");
  if (has_picture(scene)) write_environment(*scene.environment, picture);
  write_file_atomically(beside(file, ".lucarium.json"), sidecar_json(scene, picture).dump(2) + "\n");
}

}  // namespace lucarium
