// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/scene/look_at.h"

namespace lucarium {

namespace {

/// What is interpolated: eye, target, field of view.
struct Value {
  glm::dvec3 eye, target;
  double vfov;
};

Value operator+(const Value& a, const Value& b) { return {a.eye + b.eye, a.target + b.target, a.vfov + b.vfov}; }
Value operator*(double s, const Value& a) { return {s * a.eye, s * a.target, s * a.vfov}; }

Value value_of(const CameraKey& key) {
  return {glm::dvec3(key.eye), glm::dvec3(key.target), static_cast<double>(key.vfov_degrees)};
}

/// Of the straight piece behind key i.
Value difference(const CameraPath& path, size_t i) {
  const double h = path.keys[i + 1].seconds - path.keys[i].seconds;
  return (1 / h) * (value_of(path.keys[i + 1]) + -1.0 * value_of(path.keys[i]));
}

/// The derivative at key i.
Value slope(const CameraPath& path, size_t i) {
  const size_t last = path.keys.size() - 1;
  if (last == 1) return difference(path, 0);
  if (i == 0) return 2.0 * difference(path, 0) + -1.0 * slope(path, 1);
  if (i == last) return 2.0 * difference(path, last - 1) + -1.0 * slope(path, last - 1);
  const double before = path.keys[i].seconds - path.keys[i - 1].seconds,
               after = path.keys[i + 1].seconds - path.keys[i].seconds;
  return (1 / (before + after)) * (after * difference(path, i - 1) + before * difference(path, i));
}

bool finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

std::string_view interpolation_name(CameraPath::Interpolation interpolation) {
  return interpolation == CameraPath::Interpolation::spline ? "spline" : "linear";
}

CameraKey sample_camera_path(const CameraPath& path, double seconds) {
  const std::vector<CameraKey>& keys = path.keys;
  if (seconds <= keys.front().seconds) return keys.front();
  if (seconds >= keys.back().seconds) return keys.back();
  const auto next = std::upper_bound(keys.begin(), keys.end(), seconds,
                                     [](double time, const CameraKey& key) { return time < key.seconds; });
  const auto i = static_cast<size_t>(next - keys.begin()) - 1;
  const CameraKey &a = keys[i], &b = keys[i + 1];
  if (seconds == a.seconds) return a;  // to the bit
  const double h = b.seconds - a.seconds, s = (seconds - a.seconds) / h;
  Value value = value_of(a) + s * (value_of(b) + -1.0 * value_of(a));
  if (path.interpolation == CameraPath::Interpolation::spline) {
    const double r = 1 - s;
    value = (r * r * (1 + 2 * s)) * value_of(a) + (s * s * (3 - 2 * s)) * value_of(b) +
            (h * s * r * r) * slope(path, i) + (-h * s * s * r) * slope(path, i + 1);
  }
  const auto [low, high] = std::minmax(a.vfov_degrees, b.vfov_degrees);
  return {seconds, glm::vec3(value.eye), glm::vec3(value.target),
          std::clamp(static_cast<float>(value.vfov), low, high)};
}

SceneCamera camera_on_path(const CameraPath& path, double seconds) {
  const CameraKey key = sample_camera_path(path, seconds);
  const float near = glm::length(key.target - key.eye),
              size = std::max(1e-30f, glm::length(key.target) + glm::length(key.eye));
  if (!(near > 1e-5f * size))
    throw_error(ErrorClass::input, "camera path: eye and target meet at {:g} s; move a key, or add one between",
                seconds);
  return look_at_camera(path.name.empty() ? "camera path" : path.name, key.eye, key.target, key.vfov_degrees);
}

std::string camera_path_mistake(const CameraPath& path) {
  if (path.keys.size() < 2)
    return fmt::format("a path has at least two keys, this one has {}", path.keys.empty() ? "none" : "one");
  for (size_t i = 0; i < path.keys.size(); ++i) {
    const CameraKey& key = path.keys[i];
    if (!std::isfinite(key.seconds) || !finite(key.eye) || !finite(key.target) || !std::isfinite(key.vfov_degrees))
      return fmt::format("key {} has a number that is not finite", i);
    if (key.vfov_degrees <= 0 || key.vfov_degrees >= 180)
      return fmt::format("key {}: the vertical field of view must be between 0 and 180 degrees", i);
    if (key.eye == key.target) return fmt::format("key {}: eye and target are the same point", i);
    if (i > 0 && !(path.keys[i - 1].seconds < key.seconds))
      return fmt::format("key {} is at {} s, the one before at {} s; times must ascend", i, key.seconds,
                         path.keys[i - 1].seconds);
  }
  return "";
}

std::string camera_text(const CameraKey& key) {
  return fmt::format("{},{},{}:{},{},{}:{}", key.eye.x, key.eye.y, key.eye.z, key.target.x, key.target.y, key.target.z,
                     key.vfov_degrees);
}

}  // namespace lucarium
