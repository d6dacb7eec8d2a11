// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "lucarium/shared/light_tree.h"

namespace lucarium {
namespace {

constexpr float half_turn = glm::pi<float>();
constexpr size_t children = 8, bins = 16;

/// More than what is lost where angles become cosines [rad].
constexpr float cone_slack = 1e-3f;

/// Between unit vectors [rad].
float angle_between(const glm::vec3& a, const glm::vec3& b) {
  return 2 * std::asin(std::min(0.5f * glm::length(a - b), 1.f));
}

/// The smallest cone around two (Conty Estevez and Kulla 2018, algorithm 1), as axis and half angle.
void join_cones(LightBounds& a, const LightBounds& b) {
  const LightBounds &wide = a.spread >= b.spread ? a : b, &narrow = a.spread >= b.spread ? b : a;
  const float between = angle_between(a.axis, b.axis), end = between + narrow.spread;
  glm::vec3 axis = wide.axis;
  float spread = wide.spread;
  if (end > spread) {
    spread = 0.5f * (wide.spread + end);
    const glm::vec3 across = narrow.axis - glm::dot(narrow.axis, wide.axis) * wide.axis;
    const float length = glm::length(across), turn = spread - wide.spread;
    if (length > 1e-6f)
      axis = glm::normalize(std::cos(turn) * wide.axis + std::sin(turn) / length * across);
    else if (between > 1)
      spread = half_turn;  // opposite axes
  }
  a.axis = axis;
  a.spread = std::min(spread, half_turn);
}

void add_bounds(LightBounds& sum, const LightBounds& light) {
  if (!(sum.power > 0)) {
    sum = light;
    return;
  }
  sum.lower = glm::min(sum.lower, light.lower);
  sum.upper = glm::max(sum.upper, light.upper);
  join_cones(sum, light);
  sum.reach = std::max(sum.reach, light.reach);
  sum.power += light.power;
}

/// Solid angle of directions in which such lights send something, weighted by the cosine beyond the cone [sr].
float cone_measure(const LightBounds& b) {
  const float to = std::min(b.spread + b.reach, half_turn), c = std::cos(b.spread), s = std::sin(b.spread);
  return 2 * half_turn * (1 - c) + 0.5f * half_turn * (2 * to * s - std::cos(b.spread - 2 * to) - 2 * b.spread * s + c);
}

/// How badly such lights are bounded.
float split_cost(const LightBounds& b) {
  const glm::vec3 diagonal = b.upper - b.lower;  // of lights in a row a box has no area, the sphere around it has
  return b.power * glm::dot(diagonal, diagonal) * cone_measure(b);
}

uint word(float x) { return std::bit_cast<uint>(x); }

class LightTreeBuilder {
 public:
  LightTreeBuilder(const std::vector<LightBounds>& bounds, LightTree& tree) : bounds_(bounds), tree_(tree) {}

  /// Appends the tree over these lights, which it reorders; returns where its root begins.
  uint build(uint* begin, uint* end, uint place) {
    const std::vector<Part> parts = divide(begin, end);
    const uint node = static_cast<uint>(tree_.nodes.size());
    tree_.nodes.resize(tree_.nodes.size() + LUCARIUM_LIGHT_NODE_WORDS, 0);
    tree_.nodes[node + LUCARIUM_LIGHT_NODE_PLACE] = place;
    for (uint k = 0; k < parts.size(); ++k) {
      write_child(node, k, parts[k]);
      const bool leaf = parts[k].count() == 1;
      const uint child = leaf ? LUCARIUM_LIGHT_LEAF | *parts[k].begin : build(parts[k].begin, parts[k].end, node | k);
      if (leaf) tree_.places[*parts[k].begin] = node | k;
      tree_.nodes[node + LUCARIUM_LIGHT_NODE_CHILD + k] = child;
    }
    return node;
  }

 private:
  struct Part {
    uint *begin, *end;
    LightBounds bounds;
    size_t count() const { return static_cast<size_t>(end - begin); }
    /// Those that fit into one node come last.
    float priority() const { return count() > children ? split_cost(bounds) : -1.f; }
  };

  /// Divides what is bounded worst until there are as many children as a node has, or none that needs two nodes.
  std::vector<Part> divide(uint* begin, uint* end) const {
    std::vector<Part> parts;
    if (static_cast<size_t>(end - begin) <= children) {
      for (uint* i = begin; i < end; ++i) parts.push_back(part(i, i + 1));
      return parts;
    }
    parts.push_back(part(begin, end));
    while (parts.size() < children) {
      const auto worst = std::max_element(parts.begin(), parts.end(),
                                          [](const Part& a, const Part& b) { return a.priority() < b.priority(); });
      if (worst->count() <= children) break;
      uint* const middle = split(*worst);
      const Part left = part(worst->begin, middle), right = part(middle, worst->end);
      *worst = left;
      parts.insert(worst + 1, right);
    }
    return parts;
  }

  Part part(uint* begin, uint* end) const {
    Part p{begin, end, {}};
    for (const uint* i = begin; i < end; ++i) add_bounds(p.bounds, bounds_[*i]);
    return p;
  }

  /// Half angle of the cone about the axis that holds all of them [rad].
  float spread_of(const Part& p) const {
    float spread = 0;
    for (const uint* i = p.begin; i < p.end; ++i)
      spread = std::max(spread, angle_between(p.bounds.axis, bounds_[*i].axis) + bounds_[*i].spread);
    return spread > 0 ? std::min(spread + cone_slack, half_turn) : 0;
  }

  void write_child(uint node, uint k, const Part& p) {
    uint* const row = &tree_.nodes[node] + k;
    const glm::vec3 center = 0.5f * (p.bounds.lower + p.bounds.upper);
    // Bounds of all together are wider than need be.
    float radius = 0;
    for (const uint* i = p.begin; i < p.end; ++i) {
      const LightBounds& b = bounds_[*i];
      radius = std::max(radius, glm::length(middle_of(b) - center) + 0.5f * glm::length(b.upper - b.lower));
    }
    radius = std::min(radius, 0.5f * glm::length(p.bounds.upper - p.bounds.lower));
    const float spread = spread_of(p);
    for (int axis = 0; axis < 3; ++axis) {
      row[LUCARIUM_LIGHT_NODE_CENTER + children * axis] = word(center[axis]);
      row[LUCARIUM_LIGHT_NODE_AXIS + children * axis] = word(p.bounds.axis[axis]);
    }
    const glm::vec3 farthest = glm::max(glm::abs(p.bounds.lower), glm::abs(p.bounds.upper));
    const float rounding = 4e-7f * std::max(farthest.x, std::max(farthest.y, farthest.z));
    row[LUCARIUM_LIGHT_NODE_RADIUS] = word(radius * 1.0001f + (radius > 0 ? rounding : 0.f));
    row[LUCARIUM_LIGHT_NODE_POWER] = word(p.bounds.power);
    row[LUCARIUM_LIGHT_NODE_COS_CONE] = word(spread < half_turn ? std::cos(spread) : -1.f);
    row[LUCARIUM_LIGHT_NODE_SIN_CONE] = word(spread < half_turn ? std::sin(spread) : 0.f);
    row[LUCARIUM_LIGHT_NODE_COS_REACH] = word(std::cos(p.bounds.reach) - 1e-5f);
  }

  static glm::vec3 middle_of(const LightBounds& b) { return 0.5f * (b.lower + b.upper); }

  /// Divides it in two, neither of them empty.
  uint* split(const Part& p) const {
    glm::vec3 lower(std::numeric_limits<float>::max()), upper(-lower);
    for (const uint* i = p.begin; i < p.end; ++i) {
      lower = glm::min(lower, middle_of(bounds_[*i]));
      upper = glm::max(upper, middle_of(bounds_[*i]));
    }
    float best = std::numeric_limits<float>::max();
    int best_axis = -1;
    size_t best_bin = 0;
    const auto bin_of = [&](uint light, int axis) {
      const float at = (middle_of(bounds_[light])[axis] - lower[axis]) / (upper[axis] - lower[axis]);
      return std::min(static_cast<size_t>(at * static_cast<float>(bins)), bins - 1);
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (!(upper[axis] > lower[axis])) continue;
      std::array<LightBounds, bins> content{}, behind{};
      for (const uint* i = p.begin; i < p.end; ++i) add_bounds(content[bin_of(*i, axis)], bounds_[*i]);
      for (size_t k = bins - 1; k > 0; --k) {
        behind[k - 1] = behind[k];
        if (content[k].power > 0) add_bounds(behind[k - 1], content[k]);
      }
      LightBounds before{};
      for (size_t k = 0; k + 1 < bins; ++k) {
        if (content[k].power > 0) add_bounds(before, content[k]);
        if (!(before.power > 0) || !(behind[k].power > 0)) continue;
        const float cost = split_cost(before) + split_cost(behind[k]);
        if (cost < best) best = cost, best_axis = axis, best_bin = k;
      }
    }
    if (best_axis < 0) return p.begin + p.count() / 2;  // all in one place
    return std::stable_partition(p.begin, p.end, [&](uint light) { return bin_of(light, best_axis) <= best_bin; });
  }

  const std::vector<LightBounds>& bounds_;
  LightTree& tree_;
};

}  // namespace

size_t light_tree_capacity(size_t lights) {
  // A chain of nodes, each above seven of two lights and the next, has most; and each kind has a root.
  const size_t nodes = lights * 4 / 7 + 2 * LUCARIUM_LIGHT_KINDS;
  return nodes * LUCARIUM_LIGHT_NODE_WORDS;
}

LightTree make_light_tree(const std::vector<Light>& lights, const std::vector<LightBounds>& bounds, bool in_use) {
  LightTree tree;
  tree.header.resize(LUCARIUM_LIGHT_TREES_WORDS, 0);
  tree.places.resize(lights.size(), LUCARIUM_NONE);
  if (!in_use) return tree;
  LightTreeBuilder builder(bounds, tree);
  for (uint kind = 0; kind < LUCARIUM_LIGHT_KINDS; ++kind) {
    std::vector<uint> members;
    for (uint i = 0; i < lights.size(); ++i)
      if (lights[i].kind == kind) members.push_back(i);
    if (members.empty()) continue;
    float power = 0;
    for (const uint i : members) power += bounds[i].power;
    tree.header[LUCARIUM_LIGHT_TREES_POWERS + kind] = word(power);
    tree.header[LUCARIUM_LIGHT_TREES_KINDS] |= 1u << kind;
    if (kind == LUCARIUM_LIGHT_ENVIRONMENT) continue;
    const uint root = builder.build(members.data(), members.data() + members.size(), LUCARIUM_NONE);
    tree.header[LUCARIUM_LIGHT_TREES_ROOTS + kind] = root;
  }
  return tree;
}

}  // namespace lucarium
