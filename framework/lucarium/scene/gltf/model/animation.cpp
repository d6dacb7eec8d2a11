// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/model/animation.h"

#include <algorithm>
#include <optional>
#include <set>

namespace lucarium::gltf {

namespace {

std::optional<AnimationPath> parse_path(const std::string& text) {
  if (text == "translation") return AnimationPath::translation;
  if (text == "rotation") return AnimationPath::rotation;
  if (text == "scale") return AnimationPath::scale;
  if (text == "weights") return AnimationPath::weights;
  return std::nullopt;
}

Interpolation parse_interpolation(const std::string& text) {
  if (text == "STEP") return Interpolation::step;
  return text == "CUBICSPLINE" ? Interpolation::cubic_spline : Interpolation::linear;
}

/// Key times must ascend; of equal ones the first is kept, for exporters repeat the last key.
void check_times(AnimationChannel& channel, size_t floats_per_key, const std::string& where, ImportContext& context) {
  size_t kept = 1;
  for (size_t i = 1; i < channel.times.size(); ++i) {
    if (channel.times[i] < channel.times[kept - 1]) context.fail("{}: its key times do not ascend (key {})", where, i);
    if (channel.times[i] == channel.times[kept - 1]) continue;
    channel.times[kept] = channel.times[i];
    std::copy_n(channel.values.begin() + static_cast<std::ptrdiff_t>(i * floats_per_key), floats_per_key,
                channel.values.begin() + static_cast<std::ptrdiff_t>(kept * floats_per_key));
    ++kept;
  }
  if (kept == channel.times.size()) return;
  context.warn("{}: {} keys repeat the time of the one before and were left out", where, channel.times.size() - kept);
  channel.times.resize(kept);
  channel.values.resize(kept * floats_per_key);
}

class AnimationImporter {
 public:
  AnimationImporter(const Document& document, Scene& scene, ImportContext& context)
      : document_(document), scene_(scene), context_(context), reader_(document, context) {}

  Animation import_one(const tinygltf::Animation& source, size_t index) {
    const std::string where = label("animation", index, source.name);
    Animation animation;
    animation.name = source.name.empty() ? fmt::format("animation {}", index) : source.name;
    std::set<std::pair<int, AnimationPath>> targets;
    for (const tinygltf::AnimationChannel& channel_source : source.channels) {
      std::optional<AnimationChannel> channel = import_channel(channel_source, source, where);
      if (!channel) continue;
      if (!targets.emplace(channel->node, channel->path).second) {
        context_.warn("{}: two channels move the same property of node {}; the last one wins", where, channel->node);
      }
      animation.duration = std::max(animation.duration, channel->times.back());
      animation.channels.push_back(std::move(*channel));
    }
    return animation;
  }

 private:
  std::optional<AnimationChannel> import_channel(const tinygltf::AnimationChannel& source,
                                                 const tinygltf::Animation& animation, const std::string& where) {
    const std::optional<AnimationPath> path = parse_path(source.target_path);
    if (!path) {
      context_.warn("{}: animating '{}' is not supported; the channel was left out", where, source.target_path);
      return std::nullopt;
    }
    if (source.target_node == none) return std::nullopt;
    const Node& node = scene_.nodes[source.target_node];
    if (node.matrix && *path != AnimationPath::weights) {
      context_.warn("{}: node {} has a matrix, so it cannot be animated", where, source.target_node);
      return std::nullopt;
    }
    if (*path == AnimationPath::weights && node.morph_weights.empty()) {
      context_.warn("{}: node {} has no morph targets to animate", where, source.target_node);
      return std::nullopt;
    }
    const tinygltf::AnimationSampler& sampler = animation.samplers[source.sampler];
    AnimationChannel channel;
    channel.node = source.target_node;
    channel.path = *path;
    channel.interpolation = parse_interpolation(sampler.interpolation);
    read_keys(sampler, node.morph_weights.size(), where, channel);
    return channel;
  }

  void read_keys(const tinygltf::AnimationSampler& sampler, size_t morph_targets, const std::string& where,
                 AnimationChannel& channel) {
    const int width = channel.path == AnimationPath::weights ? 1 : channel.path == AnimationPath::rotation ? 4 : 3;
    if (reader_.component_type(sampler.input) != TINYGLTF_COMPONENT_TYPE_FLOAT) {
      context_.fail("{}: its key times (/accessors/{}) must be floats", where, sampler.input);
    }
    channel.times = reader_.floats(sampler.input, 1, where + ": key times");
    channel.values = reader_.floats(sampler.output, width, where + ": key values");
    const size_t per_value = width == 1 ? morph_targets : static_cast<size_t>(width);
    const size_t per_key = per_value * (channel.interpolation == Interpolation::cubic_spline ? 3 : 1);
    if (channel.values.size() != channel.times.size() * per_key) {
      context_.fail("{}: {} numbers for {} keys of {} each (/accessors/{})", where, channel.values.size(),
                    channel.times.size(), per_key, sampler.output);
    }
    check_times(channel, per_key, where, context_);
  }

  const Document& document_;
  Scene& scene_;
  ImportContext& context_;
  AccessorReader reader_;
};

}  // namespace

void import_animations(const Document& document, Scene& scene, ImportContext& context) {
  AnimationImporter importer(document, scene, context);
  for (size_t i = 0; i < document.model.animations.size(); ++i) {
    scene.animations.push_back(importer.import_one(document.model.animations[i], i));
  }
}

}  // namespace lucarium::gltf
