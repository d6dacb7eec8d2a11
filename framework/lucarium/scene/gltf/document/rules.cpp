// SPDX-License-Identifier: Apache-2.0
// The properties of glTF 2.0 (section 5) and of the extensions that are read, as rules for check_json(). Value ranges
// are stated where a value outside has no meaning; those that are merely unphysical are clamped with a warning later.
// Declared in schema.h.
#include "lucarium/scene/gltf/document/schema.h"

namespace lucarium::gltf {

namespace {

using Kind = Rule::Kind;
using Rules = std::vector<Rule>;

constexpr double largest_integer = 9007199254740992.0;  // 2^53: exact in JSON's numbers
constexpr double largest_int = 2147483647.0;            // tinygltf keeps some offsets as int

Rule plain(const char* key, Kind kind) {
  Rule rule;
  rule.key = key, rule.kind = kind;
  return rule;
}

Rule number(const char* key, double min = -FLT_MAX, double max = FLT_MAX) {
  Rule rule = plain(key, Kind::number);
  rule.min = min, rule.max = max;
  return rule;
}

Rule integer(const char* key, double min = 0, double max = largest_integer) {
  Rule rule = plain(key, Kind::integer);
  rule.min = min, rule.max = max;
  return rule;
}

Rule numbers(const char* key, size_t length = 0) {
  Rule rule = plain(key, Kind::numbers);
  rule.length = length;
  return rule;
}

Rule choice(const char* key, std::vector<Json> choices) {
  Rule rule = plain(key, Kind::choice);
  rule.choices = std::move(choices);
  return rule;
}

Rule reference(Kind kind, const char* key, const char* target) {
  Rule rule = plain(key, kind);
  rule.target = target;
  return rule;
}

Rule index(const char* key, const char* target) { return reference(Kind::index, key, target); }

Rule nested(Kind kind, const char* key, Rules members) {
  Rule rule = plain(key, kind);
  rule.members = std::move(members);
  return rule;
}

Rule object(const char* key, Rules members) { return nested(Kind::object, key, std::move(members)); }
Rule objects(const char* key, Rules members) { return nested(Kind::objects, key, std::move(members)); }
Rule extensions(Rules members) { return object("extensions", std::move(members)); }

constexpr double positive = FLT_MIN;  ///< smallest number that counts as above 0

Rules accessor() {
  const std::vector<Json> components = {5120, 5121, 5122, 5123, 5125, 5126};
  return {
      index("bufferView", "/bufferViews"),
      integer("byteOffset"),
      choice("componentType", components).needed(),
      plain("normalized", Kind::boolean),
      integer("count", 1).needed(),
      choice("type", {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}).needed(),
      numbers("min"),
      numbers("max"),
      object("sparse",
             {integer("count", 1, largest_int).needed(),
              object("indices", {index("bufferView", "/bufferViews").needed(), integer("byteOffset", 0, largest_int),
                                 choice("componentType", {5121, 5123, 5125}).needed()})
                  .needed(),
              object("values", {index("bufferView", "/bufferViews").needed(), integer("byteOffset", 0, largest_int)})
                  .needed()})};
}

Rules buffer_view() {
  return {index("buffer", "/buffers").needed(), integer("byteOffset"), integer("byteLength", 1).needed(),
          integer("byteStride", 4, 252), integer("target")};
}

Rule texture(const char* key) {
  return object(
      key,
      {index("index", "/textures").needed(), integer("texCoord", 0, largest_int), number("scale"), number("strength"),
       extensions({object("KHR_texture_transform", {numbers("offset", 2), number("rotation"), numbers("scale", 2),
                                                    integer("texCoord", 0, largest_int)})})});
}

Rules material_extensions() {
  return {object("KHR_materials_emissive_strength", {number("emissiveStrength")}),
          object("KHR_materials_ior", {number("ior")}),
          object("KHR_materials_transmission", {number("transmissionFactor"), texture("transmissionTexture")}),
          object("KHR_materials_volume", {number("thicknessFactor"), texture("thicknessTexture"),
                                          number("attenuationDistance"), numbers("attenuationColor", 3)}),
          object("KHR_materials_unlit", {}),
          object("KHR_materials_pbrSpecularGlossiness",
                 {numbers("diffuseFactor", 4), texture("diffuseTexture"), numbers("specularFactor", 3),
                  number("glossinessFactor"), texture("specularGlossinessTexture")})};
}

Rules material() {
  return {object("pbrMetallicRoughness",
                 {numbers("baseColorFactor", 4), texture("baseColorTexture"), number("metallicFactor"),
                  number("roughnessFactor"), texture("metallicRoughnessTexture")}),
          texture("normalTexture"),
          texture("occlusionTexture"),
          texture("emissiveTexture"),
          numbers("emissiveFactor", 3),
          plain("alphaMode", Kind::text),
          number("alphaCutoff"),
          plain("doubleSided", Kind::boolean),
          extensions(material_extensions())};
}

Rules mesh() {
  return {objects("primitives",
                  {reference(Kind::index_map, "attributes", "/accessors").needed(), index("indices", "/accessors"),
                   index("material", "/materials"), integer("mode", 0, 6),
                   reference(Kind::index_maps, "targets", "/accessors"),
                   extensions({object("KHR_draco_mesh_compression", {index("bufferView", "/bufferViews").needed()})})})
              .needed(),
          numbers("weights")};
}

Rules node() {
  return {index("camera", "/cameras"),
          reference(Kind::indices, "children", "/nodes"),
          index("skin", "/skins"),
          numbers("matrix", 16),
          index("mesh", "/meshes"),
          numbers("rotation", 4),
          numbers("scale", 3),
          numbers("translation", 3),
          numbers("weights"),
          extensions(
              {object("KHR_lights_punctual", {index("light", "/extensions/KHR_lights_punctual/lights").needed()}),
               object("EXT_mesh_gpu_instancing", {reference(Kind::index_map, "attributes", "/accessors").needed()})})};
}

Rules animation() {
  return {
      objects("channels", {integer("sampler", 0, largest_int).needed(),
                           object("target", {index("node", "/nodes"), plain("path", Kind::text).needed()}).needed()})
          .needed(),
      objects("samplers", {index("input", "/accessors").needed(), index("output", "/accessors").needed(),
                           choice("interpolation", {"LINEAR", "STEP", "CUBICSPLINE"})})
          .needed()};
}

Rules camera() {
  return {plain("type", Kind::text).needed(),
          object("perspective", {number("aspectRatio", positive), number("yfov", positive).needed(),
                                 number("zfar", positive), number("znear", positive).needed()}),
          object("orthographic", {number("xmag").needed(), number("ymag").needed(), number("zfar").needed(),
                                  number("znear").needed()})};
}

Rules light() {
  return {plain("type", Kind::text).needed(), numbers("color", 3), number("intensity"), number("range"),
          object("spot", {number("innerConeAngle"), number("outerConeAngle")})};
}

Rules texture_object() {
  // Exporters leave sources behind that point nowhere; such textures are left out with a warning.
  return {index("sampler", "/samplers"), integer("source", 0, largest_int)};
}

Rules document() {
  return {
      plain("extensionsUsed", Kind::texts),
      plain("extensionsRequired", Kind::texts),
      objects("accessors", accessor()),
      objects("animations", animation()),
      objects("buffers", {plain("uri", Kind::text), integer("byteLength", 1).needed()}),
      objects("bufferViews", buffer_view()),
      objects("cameras", camera()),
      objects("images", {plain("uri", Kind::text), plain("mimeType", Kind::text), index("bufferView", "/bufferViews")}),
      objects("materials", material()),
      objects("meshes", mesh()),
      objects("nodes", node()),
      objects("samplers", {integer("magFilter", 0, largest_int), integer("minFilter", 0, largest_int),
                           integer("wrapS", 0, largest_int), integer("wrapT", 0, largest_int)}),
      index("scene", "/scenes"),
      objects("scenes", {reference(Kind::indices, "nodes", "/nodes")}),
      objects("skins", {index("inverseBindMatrices", "/accessors"), index("skeleton", "/nodes"),
                        reference(Kind::indices, "joints", "/nodes").needed()}),
      objects("textures", texture_object()),
      extensions({object("KHR_lights_punctual", {objects("lights", light()).needed()}),
                  object("KHR_materials_variants", {objects("variants", {plain("name", Kind::text).needed()})})})};
}

}  // namespace

const std::vector<Rule>& gltf_rules() {
  static const std::vector<Rule> rules = document();
  return rules;
}

}  // namespace lucarium::gltf
