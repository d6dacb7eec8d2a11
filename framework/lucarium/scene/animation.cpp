// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/animation.h"

#include <algorithm>
#include <cmath>

namespace lucarium {

namespace {

glm::quat to_quaternion(const float* v) { return {v[3], v[0], v[1], v[2]}; }

std::vector<float> to_vector(const glm::quat& q) { return {q.x, q.y, q.z, q.w}; }

/// Hermite spline of glTF's appendix C.4; `step` is the distance of the two keys.
std::vector<float> cubic_spline(const AnimationChannel& channel, size_t components, size_t key, float s, float step) {
  const float* v0 = channel.values.data() + (3 * key + 1) * components;
  const float* out0 = v0 + components;
  const float* in1 = out0 + components;
  const float* v1 = in1 + components;
  const float s2 = s * s, s3 = s2 * s;
  std::vector<float> result(components);
  for (size_t c = 0; c < components; ++c) {
    result[c] = (2 * s3 - 3 * s2 + 1) * v0[c] + step * (s3 - 2 * s2 + s) * out0[c] + (3 * s2 - 2 * s3) * v1[c] +
                step * (s3 - s2) * in1[c];
  }
  return result;
}

}  // namespace

size_t channel_components(const AnimationChannel& channel) {
  const size_t keys = channel.times.size() * (channel.interpolation == Interpolation::cubic_spline ? 3 : 1);
  return keys == 0 ? 0 : channel.values.size() / keys;
}

std::vector<float> sample_channel(const AnimationChannel& channel, double seconds) {
  const size_t components = channel_components(channel), keys = channel.times.size();
  if (components == 0) return {};
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  const bool rotation = channel.path == AnimationPath::rotation && components == 4;
  const auto value = [&](size_t key) { return channel.values.data() + (cubic ? 3 * key + 1 : key) * components; };

  // Find the last key that is not after the time.
  const float time = static_cast<float>(seconds);
  const size_t after = std::upper_bound(channel.times.begin(), channel.times.end(), time) - channel.times.begin();
  const size_t key = after == 0 ? 0 : after - 1;
  std::vector<float> result(value(key), value(key) + components);
  if (after > 0 && after < keys && channel.interpolation != Interpolation::step) {
    const float step = channel.times[key + 1] - channel.times[key];
    const float s = step > 0 ? (time - channel.times[key]) / step : 0.f;
    if (cubic) {
      result = cubic_spline(channel, components, key, s, step);
    } else if (rotation) {
      result = to_vector(
          glm::slerp(glm::normalize(to_quaternion(value(key))), glm::normalize(to_quaternion(value(key + 1))), s));
    } else {
      for (size_t c = 0; c < components; ++c) result[c] = (1 - s) * value(key)[c] + s * value(key + 1)[c];
    }
  }
  if (rotation) {
    const glm::quat q = to_quaternion(result.data());
    result = to_vector(glm::length(q) > 0 ? glm::normalize(q) : glm::quat(1, 0, 0, 0));
  }
  return result;
}

double looped_time(double seconds, double duration) {
  if (!(duration > 0)) return 0;
  const double time = std::fmod(seconds, duration);
  return time < 0 ? time + duration : time;
}

bool moves_only_cameras(const Scene& scene) {
  const std::vector<bool> moving = animated_nodes(scene);
  const auto still = [&](int node) { return node == none || !moving[static_cast<size_t>(node)]; };
  for (const SceneInstance& instance : scene.instances) {
    if (!still(instance.node)) return false;
    if (instance.node == none || scene.nodes[static_cast<size_t>(instance.node)].skin == none) continue;
    const Skin& skin = scene.skins[static_cast<size_t>(scene.nodes[static_cast<size_t>(instance.node)].skin)];
    if (!std::all_of(skin.joints.begin(), skin.joints.end(), still)) return false;
  }
  return std::all_of(scene.lights.begin(), scene.lights.end(), [&](const SceneLight& l) { return still(l.node); });
}

std::vector<bool> animated_nodes(const Scene& scene) {
  std::vector<bool> moving(scene.nodes.size());
  std::vector<int> stack;
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) stack.push_back(channel.node);
  }
  while (!stack.empty()) {
    const int node = stack.back();
    stack.pop_back();
    if (node == none || moving[static_cast<size_t>(node)]) continue;
    moving[static_cast<size_t>(node)] = true;
    const std::vector<int>& children = scene.nodes[static_cast<size_t>(node)].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
  return moving;
}

}  // namespace lucarium
