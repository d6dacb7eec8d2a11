// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// Number of floats per key of a channel (3, 4, or one per morph target), derived from the sizes of its arrays.
size_t channel_components(const AnimationChannel& channel);

/// The channel's value at `seconds` (glTF 2.0, section 3.11 and appendix C): clamped before the first and after the
/// last key; rotations (x, y, z, w) are interpolated spherically and returned with unit length.
std::vector<float> sample_channel(const AnimationChannel& channel, double seconds);

/// The time inside [0, duration) at which a looped animation is sampled; 0 where the duration is 0.
double looped_time(double seconds, double duration);

/// Whether no animation moves or deforms an instance, or moves a light: frames differ by their cameras at most.
bool moves_only_cameras(const Scene& scene);

/// Per node: whether some animation moves it, or one of its ancestors.
std::vector<bool> animated_nodes(const Scene& scene);

}  // namespace lucarium
