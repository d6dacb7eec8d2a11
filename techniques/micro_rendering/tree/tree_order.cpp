// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/tree/tree_order.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>

#include "lucarium/base/parallel.h"

namespace lucarium::micro {
namespace {

struct Item {
  glm::vec3 position, normal;
  uint32_t index;
};

constexpr float kThin = 0.5f;       // thickness of a sheet over its longest extent
constexpr float kOpposed = 0.5f;    // cosine beyond which normals belong to one of its sides
constexpr int kHeights = 32;        // steps in which gaps between layers are looked for
constexpr int kGap = 6;             // fewest empty ones between two layers
constexpr float kLean = 1e-3f;      // of planes that part points against the axis
constexpr float kOtherFace = 0.7f;  // cosine below which normals belong to another face
constexpr float kOneFace = 0.94f;   // cosine to one normal of a face, of all of them
constexpr float kCommon = 0.1f;     // share of their extent that two faces at an edge may have in common
constexpr size_t kFewest = 16;      // points of which faces are parted; pairs show how fine details are
constexpr float kFlat = 1e-3f;      // thickness over longest extent below which a sheet has one layer

/// What a thin sheet is parted by: points below `height` along `normal`, or those that face against it. What two faces
/// are parted by: points of the other one.
struct Sheet {
  glm::vec3 normal{0};
  bool two_sided = false, layered = false, bent = false;
  float height = 0;
  bool first(const Item& item) const {
    if (bent) return glm::dot(item.normal, normal) < kOtherFace;
    return two_sided ? glm::dot(item.normal, normal) < 0 : glm::dot(item.position, normal) < height;
  }
};

/// Whether both parts reach over half of the shorter one's extent along `axis`, so that one lies before the other.
bool parts_overlap(std::span<const Item> items, const Sheet& sheet, int axis) {
  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (const Item& item : items) {
    const int part = sheet.first(item);
    low[part] = std::min(low[part], item.position[axis]), high[part] = std::max(high[part], item.position[axis]);
  }
  const float common = std::min(high[0], high[1]) - std::max(low[0], low[1]);
  return common > 0 && common >= 0.5f * std::min(high[0] - low[0], high[1] - low[1]);
}

/// Thin sheets about the normal of the point of least index (whatever order the library has left) whose parts a node
/// must not mix: the two sides of one, of which one is seen, and parallel layers, of which one hides the other.
Sheet find_sheet(std::span<const Item> items, int axis, float longest) {
  Sheet sheet;
  sheet.normal = std::min_element(items.begin(), items.end(), [](const Item& a, const Item& b) {
                   return a.index < b.index;
                 })->normal;
  float low = INFINITY, high = -INFINITY, least = 1;
  for (const Item& item : items) {
    const float height = glm::dot(item.position, sheet.normal);
    low = std::min(low, height), high = std::max(high, height);
    if (high - low > kThin * longest) return sheet;
    least = std::min(least, glm::dot(item.normal, sheet.normal));
  }
  sheet.two_sided = least < -kOpposed;
  if (sheet.two_sided || !(high - low > kFlat * longest)) return sheet;
  bool filled[kHeights] = {};
  const float scale = kHeights / (high - low);
  for (const Item& item : items)
    filled[std::clamp(static_cast<int>((glm::dot(item.position, sheet.normal) - low) * scale), 0, kHeights - 1)] = true;
  int widest = 0, end = 0;
  for (int i = 0, run = 0; i < kHeights; ++i) {
    run = filled[i] ? 0 : run + 1;
    if (run > widest) widest = run, end = i + 1;
  }
  sheet.height = low + (static_cast<float>(end) - 0.5f * static_cast<float>(widest)) / scale;
  sheet.layered = widest >= kGap && parts_overlap(items, sheet, axis);
  return sheet;
}

/// Whether the points lie on two faces that meet at one edge, the sheet's and that of the least other point: all
/// normals are theirs, and a plane through the edge parts them. A node that holds both shows the mean of their light to
/// all sides, and stands out at outlines.
bool has_two_faces(std::span<const Item> items, const Sheet& sheet) {
  if (items.size() < kFewest) return false;
  const Item* other = nullptr;
  for (const Item& item : items)
    if (glm::dot(item.normal, sheet.normal) < kOtherFace && (!other || item.index < other->index)) other = &item;
  if (!other) return false;
  const glm::vec3 across = sheet.normal - other->normal;
  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (const Item& item : items) {
    const float own = glm::dot(item.normal, sheet.normal), others = glm::dot(item.normal, other->normal);
    if (std::max(own, others) < kOneFace) return false;
    const int part = own < kOtherFace;
    const float place = glm::dot(item.position, across);
    low[part] = std::min(low[part], place), high[part] = std::max(high[part], place);
  }
  const float common = std::min(high[0], high[1]) - std::max(low[0], low[1]);
  return common <= kCommon * (std::max(high[0], high[1]) - std::min(low[0], low[1]));
}

/// Equal keys are ordered by index, so that the result does not depend on the library's algorithm.
template <class Key>
void partition_at_median(std::span<Item> items, Key key) {
  std::nth_element(items.begin(), items.begin() + items.size() / 2, items.end(), [&](const Item& a, const Item& b) {
    const float ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a.index < b.index;
  });
}

/// Halves the list at the median of its longest axis, and both halves in the same manner, except for thin sheets and
/// for edges between two faces (Ritschel et al. 2009, section 2.1).
void split(std::span<Item> items, ForkJoin& fork_join) {
  if (items.size() < 2 || interrupt_requested()) return;
  glm::vec3 low = items[0].position, high = low;
  for (const Item& item : items) low = glm::min(low, item.position), high = glm::max(high, item.position);
  const glm::vec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3, second = extent[u] >= extent[v] ? u : v;
  Sheet sheet = find_sheet(items, axis, extent[axis]);
  sheet.bent = !sheet.two_sided && !sheet.layered && has_two_faces(items, sheet);
  if (sheet.two_sided || sheet.layered || sheet.bent) {
    // Along the one part and back along the other: where they hold different numbers of points, what is mixed lies
    // together at the end, and the rest is as compact as without parting.
    partition_at_median(items, [&](const Item& item) {
      const float x = item.position[axis] - high[axis];
      return sheet.first(item) ? -x : x;
    });
  } else {
    // Where the median falls within a layer across the axis, its points are parted along the layer, not at random: two
    // halves over the same place, each with the discs of half its area, would leave holes. Relative to the node, since
    // far from the origin so little a slant would be rounded away.
    partition_at_median(items, [=](const Item& item) {
      const glm::vec3 place = item.position - low;
      return place[axis] + kLean * place[second];
    });
  }
  const size_t half = items.size() / 2;
  const auto left = items.first(half), right = items.subspan(half);
  fork_join.run(
      items.size() > 4096, [&] { split(left, fork_join); }, [&] { split(right, fork_join); });
}

}  // namespace

std::vector<uint32_t> tree_order(std::span<const SampledPoint> points, int threads) {
  std::vector<Item> items(points.size());
  for (uint32_t i = 0; i < items.size(); ++i) items[i] = {points[i].position, points[i].normal, i};
  ForkJoin fork_join(static_cast<unsigned>(threads));
  split(items, fork_join);
  throw_if_interrupted("order of points");
  std::vector<uint32_t> order(items.size());
  for (size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace lucarium::micro
