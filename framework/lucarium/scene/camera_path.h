// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

struct SceneCamera;

/// Where a camera stands at one time.
struct CameraKey {
  double seconds = 0;
  glm::vec3 eye{0}, target{0};
  float vfov_degrees = 40;
};

/// A walk of the camera: at least two keys, times ascending. Eye, target and field of view are interpolated each for
/// itself; before the first and after the last key the camera stands still.
struct CameraPath {
  enum class Interpolation { linear, spline };
  std::string name;  ///< of a path that a scene brings, else empty
  Interpolation interpolation = Interpolation::linear;
  std::vector<CameraKey> keys;
};

/// "linear", "spline"
std::string_view interpolation_name(CameraPath::Interpolation interpolation);

/// Eye, target and field of view at a time, between keys.
///   linear: v_i + s (v_{i+1} - v_i), s = (t - t_i) / h_i, h_i = t_{i+1} - t_i
///   spline: cubic Hermite. The slope at an inner key is that of the parabola through it and its neighbours,
///           (h_i d_{i-1} + h_{i-1} d_i) / (h_{i-1} + h_i) with d_i = (v_{i+1} - v_i) / h_i, at an end 2 d - m, m the
///           slope at the other end of its interval: paths of degree two are met exactly, whatever the times are.
///           The field of view stays within its two keys.
CameraKey sample_camera_path(const CameraPath& path, double seconds);

/// The camera there. Throws Error{input} where eye and target meet between two keys: there is no direction to look in.
SceneCamera camera_on_path(const CameraPath& path, double seconds);

/// What is wrong with it (fewer than two keys, times that do not ascend, eye = target, field of view, numbers that are
/// not finite), naming the key from 0; empty: nothing.
std::string camera_path_mistake(const CameraPath& path);

/// As on the command line: "EX,EY,EZ:TX,TY,TZ:VFOV", in the shortest form that gives the same camera.
std::string camera_text(const CameraKey& key);

}  // namespace lucarium
