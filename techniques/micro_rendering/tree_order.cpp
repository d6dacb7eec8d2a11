// SPDX-License-Identifier: Apache-2.0
#include "tree_order.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>
#include <thread>

namespace lucarium::micro {
namespace {

struct Item {
  glm::vec3 position, normal;
  uint32_t index;
};

constexpr float kThin = 0.25f;    // thickness of a sheet over its longest extent
constexpr float kOpposed = 0.5f;  // cosine beyond which normals belong to one of its sides

/// Whether the points lie on both sides of a thin sheet whose normal is that of the first one.
bool is_two_sided_sheet(std::span<const Item> items, float longest) {
  const glm::vec3 n = items[0].normal;
  float low = INFINITY, high = -INFINITY, least = 1;
  for (const Item& item : items) {
    const float height = glm::dot(item.position, n);
    low = std::min(low, height), high = std::max(high, height);
    if (high - low > kThin * longest) return false;
    least = std::min(least, glm::dot(item.normal, n));
  }
  return least < -kOpposed;
}

/// Equal keys are told apart by indices, so that the result does not depend on the library's algorithm.
template <class Key>
void partition_at_median(std::span<Item> items, Key key) {
  std::nth_element(items.begin(), items.begin() + items.size() / 2, items.end(), [&](const Item& a, const Item& b) {
    const float ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a.index < b.index;
  });
}

void split(std::span<Item> items, int threads) {
  if (items.size() < 2) return;
  glm::vec3 low = items[0].position, high = low;
  for (const Item& item : items) low = glm::min(low, item.position), high = glm::max(high, item.position);
  const glm::vec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  if (is_two_sided_sheet(items, extent[axis])) {
    const glm::vec3 n = items[0].normal;
    partition_at_median(items, [n](const Item& item) { return glm::dot(item.normal, n); });
  } else {
    partition_at_median(items, [axis](const Item& item) { return item.position[axis]; });
  }
  const size_t half = items.size() / 2;
  const auto left = items.first(half), right = items.subspan(half);
  if (threads > 1 && items.size() > 4096) {
    std::jthread other([&] { split(left, threads / 2); });
    split(right, threads - threads / 2);
  } else {
    split(left, 1);
    split(right, 1);
  }
}

}  // namespace

std::vector<uint32_t> tree_order(std::span<const SampledPoint> points, int threads) {
  std::vector<Item> items(points.size());
  for (uint32_t i = 0; i < items.size(); ++i) items[i] = {points[i].position, points[i].normal, i};
  split(items, threads);
  std::vector<uint32_t> order(items.size());
  for (size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace lucarium::micro
