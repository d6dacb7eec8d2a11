// SPDX-License-Identifier: Apache-2.0
#include "tree_order.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <numeric>
#include <thread>

namespace lucarium::micro {
namespace {

struct Item {
  glm::vec3 position;
  uint32_t index;
};

/// Equal coordinates are told apart by their indices, so that the result does not depend on the library's algorithm.
void split(std::span<Item> items, int threads) {
  if (items.size() < 2) return;
  glm::vec3 low = items[0].position, high = low;
  for (const Item& item : items) low = glm::min(low, item.position), high = glm::max(high, item.position);
  const glm::vec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + half, items.end(), [axis](const Item& a, const Item& b) {
    return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.index < b.index;
  });
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
  for (uint32_t i = 0; i < items.size(); ++i) items[i] = {points[i].position, i};
  split(items, threads);
  std::vector<uint32_t> order(items.size());
  for (size_t i = 0; i < items.size(); ++i) order[i] = items[i].index;
  return order;
}

}  // namespace lucarium::micro
