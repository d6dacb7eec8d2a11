// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/collapse.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lucarium/base/parallel.h"
#include "lucarium/services/bvh/box_lanes.h"

namespace lucarium {

namespace {

constexpr uint32_t planned_alone = 4096;  // triangles of a subtree that is left to one thread

using Costs = std::array<float, CollapsePlan::max_width>;
using Counts = std::array<int32_t, CollapsePlan::max_width>;

/// For totals of j roots, j ≤ `max_roots`: the cheapest way to divide them, and how many roots go left then (the
/// fewest of several). Four totals at a time.
void distribute(const Costs& left, uint32_t left_count, const Costs& right, uint32_t right_count, uint32_t max_roots,
                Costs& costs, Counts& lefts) {
  constexpr uint32_t width = CollapsePlan::max_width;
  // Shifted by k roots, the costs of one side are those of j − k roots.
  float padded[2 * width];
  std::fill_n(padded, width, INFINITY);
  const bool by_left = left_count <= right_count;
  std::copy_n(by_left ? right.data() : left.data(), width, padded + width);
  const uint32_t few = std::min({left_count, right_count, width - 1, max_roots - 1});
  for (uint32_t group = 0; group < max_roots; group += 4) {
    Lanes best = splat(INFINITY);
    IntLanes best_left = {};
    const IntLanes number = splat_int(static_cast<int>(group)) + IntLanes{1, 2, 3, 4};
    for (uint32_t i = 0; i < few; ++i) {
      const uint32_t k = by_left ? i + 1 : few - i;
      Lanes others;
      std::memcpy(&others, padded + width + group - k, sizeof(others));
      const Lanes total = splat((by_left ? left : right)[k - 1]) + others;
      const IntLanes better = total < best;
      const IntLanes goes_left = splat_int(static_cast<int>(k));
      best = better ? total : best;
      best_left = better ? (by_left ? goes_left : number - goes_left) : best_left;
    }
    std::memcpy(&costs[group], &best, sizeof(best));
    std::memcpy(&lefts[group], &best_left, sizeof(best_left));
  }
}

}  // namespace

CollapsePlan::CollapsePlan(const BinaryBvh& binary, int width, int leaf_size, unsigned threads)
    : binary_(binary),
      width_(static_cast<uint32_t>(width)),
      leaf_size_(static_cast<uint32_t>(leaf_size)),
      choices_(binary.nodes.size()) {
  if (binary.triangles.empty()) return;
  // Subtrees for the threads, and the nodes above them, children behind parents.
  struct Above {
    Subtree subtree;
    size_t left, right;
    Costs costs;
  };
  std::vector<Above> above = {{binary.root(), 0, 0, {}}};
  std::vector<size_t> jobs;
  for (size_t i = 0; i < above.size(); ++i) {
    const Subtree subtree = above[i].subtree;
    if (subtree.count <= planned_alone) {
      jobs.push_back(i);
      continue;
    }
    above[i].left = above.size(), above[i].right = above.size() + 1;
    above.push_back({binary.left(subtree), 0, 0, {}});
    above.push_back({binary.right(subtree), 0, 0, {}});
  }
  parallel_jobs(
      jobs.size(), std::min(threads, static_cast<unsigned>(jobs.size())),
      [&] { return [&](size_t job) { plan(above[jobs[job]].subtree, above[jobs[job]].costs); }; }, [](size_t) {});
  for (size_t i = above.size(); i-- > 0;)
    if (above[i].left)
      choose(above[i].subtree, above[above[i].left].costs, above[above[i].right].costs, above[i].costs);
}

void CollapsePlan::plan(const Subtree& subtree, Costs& costs) {
  if (subtree.count <= binary_.undivided) {
    costs.fill(INFINITY);
    std::fill_n(costs.begin(), subtree.count, half_area(binary_.box(subtree)));
    return;
  }
  Costs left, right;
  plan(binary_.left(subtree), left);
  plan(binary_.right(subtree), right);
  choose(subtree, left, right, costs);
}

void CollapsePlan::choose(const Subtree& subtree, const Costs& left, const Costs& right, Costs& costs) {
  const uint32_t left_count = binary_.nodes[subtree.node].left_count;
  const uint32_t max_roots = std::min(subtree.count, width_);
  Counts lefts;
  costs.fill(INFINITY);
  distribute(left, left_count, right, subtree.count - left_count, max_roots, costs, lefts);
  Choice& choice = choices_[subtree.node];
  const float area = half_area(BoxLanes(binary_.nodes[subtree.node]));
  const float inner = area + costs[max_roots - 1], leaf = subtree.count <= leaf_size_ ? area : INFINITY;
  choice.roots_left[0] = static_cast<uint8_t>(lefts[max_roots - 1]);
  choice.roots_left[1] = leaf <= inner;
  costs[0] = std::min(leaf, inner);
  choice.visits = area > 0 ? costs[0] / area : 1;
  float least = costs[0];
  for (uint32_t i = 1; i < max_roots; ++i) {
    const int32_t better = costs[i] < least ? -1 : 0;
    least = std::min(costs[i], least);
    costs[i] = least;
    if (i + 1 < max_width) choice.roots_left[i + 1] = static_cast<uint8_t>(lefts[i] & better);
  }
}

CollapsePlan::Roots CollapsePlan::children(const Subtree& subtree) const {
  Roots roots;
  if (subtree.count <= binary_.undivided) {
    if (subtree.count > 0) roots.of[roots.count++] = subtree;
    return roots;
  }
  const uint32_t left = choices_[subtree.node].roots_left[0];
  collect(binary_.left(subtree), left, roots);
  collect(binary_.right(subtree), width_ - left, roots);
  return roots;
}

void CollapsePlan::collect(const Subtree& subtree, uint32_t roots, Roots& out) const {
  roots = subtree.count <= binary_.undivided ? 1 : std::min(roots, subtree.count);
  while (roots > 1 && choices_[subtree.node].roots_left[roots] == 0) --roots;
  if (roots == 1) {
    out.of[out.count++] = subtree;
    return;
  }
  const uint32_t left = choices_[subtree.node].roots_left[roots];
  collect(binary_.left(subtree), left, out);
  collect(binary_.right(subtree), roots - left, out);
}

}  // namespace lucarium
