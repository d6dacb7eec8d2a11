// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/hash.h"
#include "lucarium/scene/bounds.h"
#include "lucarium/scene/camera_path.h"

namespace lucarium {

inline constexpr int none = -1;  ///< "no such index" in the host scene

/// Declares the special members of a large struct; scene.cpp defaults them. Implicit, they would be compiled in every
/// source that holds one.
#define LUCARIUM_COMPILED_ONCE(Type) \
  Type();                            \
  Type(const Type&);                 \
  Type(Type&&) noexcept;             \
  Type& operator=(const Type&);      \
  Type& operator=(Type&&) noexcept;  \
  ~Type();

/// Deltas of one morph target, same count as the mesh's vertices; empty where the target lacks the attribute.
struct MorphTarget {
  std::vector<glm::vec3> positions, normals, tangents;
};

/// One glTF primitive as indexed triangles in object space (points and lines are dropped with a warning; strips and
/// fans are unrolled). All attribute vectors are empty or have one entry per vertex.
struct Mesh {
  std::string name;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;   ///< never empty after import (flat ones are made, with vertices split)
  std::vector<glm::vec4> tangents;  ///< w handedness; made when a normal map needs them and the file has none
  std::vector<glm::vec2> uv[2];
  std::vector<glm::vec4> colors;  ///< linear
  std::vector<glm::uvec3> triangles;
  std::vector<std::array<uint16_t, 4>> joints;
  std::vector<glm::vec4> weights;
  std::vector<MorphTarget> morph_targets;
  bool flat_normals = false;  ///< normals were missing: recomputed after deformation
  int material = 0;

  LUCARIUM_COMPILED_ONCE(Mesh)
};

enum class Wrap : uint8_t { repeat, clamp, mirror };

/// Pixels of one image, RGBA8, rows from the top.
struct Image {
  std::string name;
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;
};

/// An image with sampler state. Whether it is decoded as sRGB depends on its use, so a texture used both ways appears
/// twice.
struct SceneTexture {
  int image = none;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  bool nearest = false;
  bool srgb = false;
};

struct TextureUse {
  int texture = none;
  int uv_set = 0;
  glm::vec2 offset{0}, scale{1};  ///< KHR_texture_transform
  float rotation = 0;             ///< [rad]
  float strength = 1;             ///< normal scale
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

struct SceneMaterial {
  std::string name;
  glm::vec4 base_color{1};
  float metallic = 1, roughness = 1;
  glm::vec3 emissive_factor{0};
  float emissive_strength = 1;
  float ior = 1.5f;
  float transmission = 0;
  float thickness = 0;                    ///< KHR_materials_volume; 0: thin wall
  float attenuation_distance = INFINITY;  ///< [m]
  glm::vec3 attenuation_color{1};
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;
  bool emits() const;               ///< the factors allow light to leave it (its texture may still be black)
  bool has_specular_lobes() const;  ///< reflects or transmits other than by Lambert's law (bsdf.clh)
  bool may_be_ideal() const;        ///< has an ideal reflection or transmission, or may by its textures
  TextureUse base_color_texture, metallic_roughness_texture, normal_texture, emissive_texture, transmission_texture;
};

enum class LightType : uint8_t { point, spot, directional };

struct SceneLight {
  std::string name;
  LightType type = LightType::point;
  glm::vec3 intensity{1};                             ///< colour × intensity: [cd] point and spot, [lx] directional
  float inner_angle = 0, outer_angle = 0.785398163f;  ///< spot half angles [rad]
  int node = none;                                    ///< whose transform places it; none: world_from_light is given
  glm::mat4 world_from_light{1};                      ///< at the evaluated time; shines along -Z
};

struct SceneCamera {
  std::string name;
  bool perspective = true;
  float yfov = 0.8f;         ///< vertical field of view [rad]
  float aspect = 0;          ///< of the file; 0: the image's. The image's aspect always wins.
  float xmag = 1, ymag = 1;  ///< orthographic half extents [m]
  int node = none;
  glm::mat4 world_from_camera{1};  ///< at the evaluated time; looks along -Z
};

/// Node transforms: either TRS (animatable) or a matrix.
struct Node {
  std::string name;
  int parent = none;
  std::vector<int> children;
  glm::vec3 translation{0}, scale{1};
  glm::quat rotation{1, 0, 0, 0};
  std::optional<glm::mat4> matrix;
  std::vector<int> meshes;  ///< the primitives of its glTF mesh
  int skin = none;
  std::vector<float> morph_weights;
  bool in_scene = true;          ///< reached from the chosen glTF scene
  glm::mat4 world_from_node{1};  ///< at the evaluated time
};

struct Skin {
  std::string name;
  std::vector<int> joints;
  std::vector<glm::mat4> inverse_bind;
};

enum class Interpolation : uint8_t { linear, step, cubic_spline };
enum class AnimationPath : uint8_t { translation, rotation, scale, weights };

struct AnimationChannel {
  int node = none;
  AnimationPath path = AnimationPath::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times;   ///< ascending [s]
  std::vector<float> values;  ///< components × keys (× 3 for cubic splines)
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels;
  float duration = 0;  ///< [s]
};

struct Scene;

/// An occurrence of a mesh. Its index is its stable id over every change.
struct SceneInstance {
  int node = none;
  int mesh = none;
  int material = none;
  glm::mat4 world_from_object{1};  ///< at the evaluated time; identity for skinned ones
  /// Skinned or morphed: the pose at the evaluated time replaces the mesh's positions, normals and tangents.
  std::shared_ptr<const Mesh> pose;
  bool mirrored = false;  ///< the skin's joints mirror it: triangles of the pose are clockwise seen from the front
  const Mesh& shape(const Scene& scene) const;  ///< the pose, else the mesh
};

/// Equirectangular radiance map [cd/m²]; direction y is up, u = ½ + atan2(z, x)/2π, v = acos(y)/π from the top.
struct Environment {
  std::string name;
  uint32_t width = 0, height = 0;   ///< 0: constant
  std::vector<glm::vec3> radiance;  ///< rows from the top
  glm::vec3 factor{1};              ///< multiplier, or the constant radiance
  glm::mat3 environment_from_world{1};
};

/// The scene on the host: the truth from which everything on the device is derived.
struct Scene {
  std::string source;  ///< file, or builtin:name
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<SceneInstance> instances;
  std::vector<SceneMaterial> materials;  ///< never empty; 0 may be the default material
  std::vector<Image> images;
  std::vector<SceneTexture> textures;
  std::vector<SceneLight> lights;
  std::vector<SceneCamera> cameras;
  std::vector<CameraPath> camera_paths;   ///< that it brings, by name
  std::optional<CameraPath> camera_path;  ///< that the first camera follows
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::optional<Environment> environment;
  float exposure = 0;  ///< of pictures [stops]; 0: not stated, of which load_scene() makes NaN: automatic (exposure.h)
  double time = 0;     ///< at which it was evaluated [s]
  int animation = 0;   ///< that was evaluated, or none

  std::vector<std::string> extensions_used, extensions_ignored;
  std::vector<std::string> warnings;  ///< one line each

  Bounds instance_bounds(int instance) const;
  Bounds bounds() const;            ///< world space, at the evaluated time
  uint64_t triangle_count() const;  ///< over all instances
  bool has_light() const;           ///< punctual, emissive or environment
  Hash128 hash() const;             ///< of everything that changes radiance (cameras and exposure do not)

  LUCARIUM_COMPILED_ONCE(Scene)
};

inline const Mesh& SceneInstance::shape(const Scene& scene) const { return pose ? *pose : scene.meshes[mesh]; }

/// Kinds of change; several may be set.
struct SceneChange {
  bool camera = false;
  bool topology = false;                              ///< instances or meshes came or went: rebuild everything
  std::vector<int> moved_instances;                   ///< rigid or affine motion
  std::vector<glm::mat4> previous_world_from_object;  ///< of the moved ones, same order
  std::vector<int> deformed_instances;                ///< skins, morphs
  std::vector<int> materials;
  bool lights = false;
  bool environment = false;
  double time = 0;
  bool geometry() const { return topology || !moved_instances.empty() || !deformed_instances.empty(); }
  bool only_camera() const { return camera && !geometry() && materials.empty() && !lights && !environment; }
  bool any() const { return geometry() || camera || !materials.empty() || lights || environment; }
};

/// Evaluates node transforms, the animation `animation` (none: rest pose), morph weights and skins at `seconds`
/// (looped over its duration), and the first camera on the camera path, if there is one; says what changed since the
/// last evaluation. Nodes keep their rest transforms. Instances, lights and cameras that hang on no node stay where
/// they are. Throws Error{input} for an animation that does not exist (0 is allowed where there is none).
SceneChange evaluate(Scene& scene, double seconds, int animation = 0);

}  // namespace lucarium
