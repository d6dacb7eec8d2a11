// SPDX-License-Identifier: Apache-2.0
// Scene::evaluate: time → node transforms → instances, lights, cameras, and what changed since the last time. Declared
// in scene.h.
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/scene/animation.h"
#include "lucarium/scene/deform.h"

namespace lucarium {

namespace {

/// What a node's animation says at one time; starts from the rest pose.
struct LocalPose {
  glm::vec3 translation, scale;
  glm::quat rotation;
  std::vector<float> weights;
};

std::vector<LocalPose> local_poses(const Scene& scene, const Animation* animation, double time) {
  std::vector<LocalPose> poses;
  poses.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) {
    poses.push_back({node.translation, node.scale, node.rotation, node.morph_weights});
  }
  if (!animation) return poses;
  for (const AnimationChannel& channel : animation->channels) {
    if (channel.node == none) continue;
    const std::vector<float> v = sample_channel(channel, time);
    LocalPose& pose = poses[channel.node];
    if (channel.path == AnimationPath::weights) {
      if (!v.empty()) pose.weights = v;
    } else if (channel.path == AnimationPath::rotation) {
      if (v.size() == 4) pose.rotation = glm::quat(v[3], v[0], v[1], v[2]);
    } else if (v.size() == 3) {
      (channel.path == AnimationPath::translation ? pose.translation : pose.scale) = glm::vec3(v[0], v[1], v[2]);
    }
  }
  return poses;
}

glm::mat4 parent_from_node(const Node& node, const LocalPose& pose) {
  if (node.matrix) return *node.matrix;  // glTF forbids animating these
  const glm::mat3 rotation = glm::mat3_cast(pose.rotation);
  glm::mat4 m(1.f);
  for (int c = 0; c < 3; ++c) m[c] = glm::vec4(rotation[c] * pose.scale[c], 0.f);
  m[3] = glm::vec4(pose.translation, 1.f);
  return m;
}

void place_nodes(Scene& scene, const std::vector<LocalPose>& poses) {
  std::vector<int> pending;
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i) {
    if (scene.nodes[i].parent == none) pending.push_back(i);
  }
  while (!pending.empty()) {
    const int index = pending.back();
    pending.pop_back();
    Node& node = scene.nodes[index];
    const glm::mat4 local = parent_from_node(node, poses[index]);
    node.world_from_node = node.parent == none ? local : scene.nodes[node.parent].world_from_node * local;
    pending.insert(pending.end(), node.children.begin(), node.children.end());
  }
}

bool same_shape(const Mesh& a, const Mesh& b) {
  return a.positions == b.positions && a.normals == b.normals && a.tangents == b.tangents;
}

/// The deformed mesh of an instance, and its transform; null for a rigid one.
std::shared_ptr<const Mesh> pose_of(const Scene& scene, const SceneInstance& instance, const LocalPose& local,
                                    glm::mat4& world_from_object, bool& mirrored) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  const Node& node = scene.nodes[instance.node];
  const bool skinned = node.skin != none && !mesh.joints.empty() && !mesh.weights.empty();
  world_from_object = skinned ? glm::mat4(1.f) : node.world_from_node;
  mirrored = false;
  if (!skinned && mesh.morph_targets.empty()) return nullptr;
  auto pose = std::make_shared<Mesh>(morph(mesh, local.weights));
  if (skinned) {
    const Skin& skeleton = scene.skins[node.skin];
    std::vector<glm::mat4> world_from_bind;
    world_from_bind.reserve(skeleton.joints.size());
    for (size_t j = 0; j < skeleton.joints.size(); ++j) {
      const glm::mat4& world_from_joint = scene.nodes[skeleton.joints[j]].world_from_node;
      world_from_bind.push_back(skeleton.inverse_bind.empty() ? world_from_joint
                                                              : world_from_joint * skeleton.inverse_bind[j]);
    }
    mirrored = skin(*pose, world_from_bind, node.world_from_node);
  }
  return pose;
}

void place_instances(Scene& scene, const std::vector<LocalPose>& poses, SceneChange& change) {
  for (int i = 0; i < static_cast<int>(scene.instances.size()); ++i) {
    SceneInstance& instance = scene.instances[i];
    if (instance.node == none) continue;
    glm::mat4 world_from_object;
    bool mirrored;
    auto pose = pose_of(scene, instance, poses[instance.node], world_from_object, mirrored);
    if (world_from_object != instance.world_from_object) {
      change.moved_instances.push_back(i);
      change.previous_world_from_object.push_back(instance.world_from_object);
      instance.world_from_object = world_from_object;
    }
    if (pose && (!instance.pose || mirrored != instance.mirrored || !same_shape(*pose, *instance.pose))) {
      change.deformed_instances.push_back(i);
      instance.pose = std::move(pose);
      instance.mirrored = mirrored;
    }
  }
}

}  // namespace

SceneChange evaluate(Scene& scene, double seconds, int animation) {
  const int count = static_cast<int>(scene.animations.size());
  if (animation != none && (animation < 0 || animation >= std::max(count, 1))) {
    throw_error(ErrorClass::input, "{}: there is no animation {}; it has {}", scene.source, animation, count);
  }
  std::optional<SceneCamera> on_path;  // may throw: before anything has changed
  if (scene.camera_path && !scene.cameras.empty()) on_path = camera_on_path(*scene.camera_path, seconds);
  const Animation* chosen = animation == none || count == 0 ? nullptr : &scene.animations[animation];
  const std::vector<LocalPose> poses = local_poses(scene, chosen, chosen ? looped_time(seconds, chosen->duration) : 0);
  place_nodes(scene, poses);

  SceneChange change;
  change.time = scene.time = seconds;
  scene.animation = animation;
  place_instances(scene, poses, change);
  for (SceneLight& light : scene.lights) {
    if (light.node == none || light.world_from_light == scene.nodes[light.node].world_from_node) continue;
    light.world_from_light = scene.nodes[light.node].world_from_node;
    change.lights = true;
  }
  for (SceneCamera& camera : scene.cameras) {
    if (camera.node == none || camera.world_from_camera == scene.nodes[camera.node].world_from_node) continue;
    camera.world_from_camera = scene.nodes[camera.node].world_from_node;
    change.camera = true;
  }
  if (on_path) {
    SceneCamera& first = scene.cameras.front();
    if (on_path->world_from_camera != first.world_from_camera || on_path->yfov != first.yfov) change.camera = true;
    first = *on_path;
  }
  return change;
}

}  // namespace lucarium
