// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/build.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lucarium/base/parallel.h"
#include "lucarium/services/bvh/binned_split.h"
#include "lucarium/services/bvh/few_triangles.h"

namespace lucarium {

namespace {

constexpr int max_sah_depth = 48;        // deeper nodes are halved by count, which bounds recursion and stacks
constexpr uint32_t split_chunk = 8192;   // triangles of a large range that one thread takes at a time
constexpr uint32_t built_alone = 16384;  // triangles of a range that is left to one thread

/// Triangles to be divided. They lie in one of two arrays, and the parts are written to the other one.
struct Range {
  uint32_t node, first, count;
  int depth;
  bool swapped;  // they lie in the second array
  BoxLanes box, centres;
};

class Builder {
 public:
  Builder(BinaryBvh& out, uint32_t leaf_size, unsigned threads)
      : out_(out), other_(out.triangles.size()), few_(FewTriangles::max_count(leaf_size)), threads_(threads) {}

  void build() {
    const Range root = make_root();
    if (threads_ < 2 || root.count <= built_alone) {
      build(root);
      return;
    }
    std::vector<Range> large = {root}, small;
    while (!large.empty()) large = divide_large(large, small);
    // The largest ones first, so that threads end together.
    std::stable_sort(small.begin(), small.end(), [](const Range& a, const Range& b) { return a.count > b.count; });
    for_all(small.size(), [&](size_t i) { build(small[i]); });
  }

 private:
  template <class Work>
  void for_all(size_t count, const Work& work) {
    parallel_jobs(
        count, std::min(threads_, static_cast<unsigned>(count)), [&] { return work; }, [](size_t) {});
  }
  BoundedTriangle* place(const Range& range) { return (range.swapped ? other_ : out_.triangles).data() + range.first; }
  BoundedTriangle* other_place(const Range& range) {
    return (range.swapped ? out_.triangles : other_).data() + range.first;
  }

  Range make_root() {
    const auto count = static_cast<uint32_t>(out_.triangles.size());
    std::vector<Range> parts;
    for (uint32_t first = 0; first < count; first += 4 * split_chunk)
      parts.push_back({0, first, std::min(4 * split_chunk, count - first), 0, false, {}, {}});
    for_all(parts.size(), [&](size_t i) { find_boxes(parts[i]); });
    for (size_t i = 1; i < parts.size(); ++i) parts[0].box.add(parts[i].box), parts[0].centres.add(parts[i].centres);
    parts[0].count = count;
    return parts[0];
  }

  void find_boxes(Range& range) {
    range.box = range.centres = BoxLanes::empty();
    for (const BoundedTriangle* triangle = place(range); triangle != place(range) + range.count; ++triangle) {
      const BoxLanes one(*triangle);
      range.box.add(one);
      range.centres.add({one.centre2(), -one.centre2()});
    }
  }

  void write_node(const Range& range, uint32_t left_count) {
    BinaryBvh::Node& node = out_.nodes[range.node];
    range.box.store(node);
    node.left_count = left_count;
    node.right = range.node + left_count;
  }

  /// Large ranges, all of a level at once: threads share their triangles. Returns those parts that are large again.
  std::vector<Range> divide_large(const std::vector<Range>& ranges, std::vector<Range>& small) {
    struct Piece {
      size_t range;
      uint32_t first, count;
      Bins bins;
      uint32_t left, right;  // where its triangles go
      SideCentres centres;
    };
    std::vector<BinMap> maps;
    std::vector<Piece> pieces;
    for (size_t i = 0; i < ranges.size(); ++i) {
      maps.emplace_back(ranges[i].centres, ranges[i].count);
      for (uint32_t first = 0; first < ranges[i].count; first += split_chunk)
        pieces.push_back({i, first, std::min(split_chunk, ranges[i].count - first), Bins(maps[i].bins), 0, 0, {}});
    }
    for_all(pieces.size(), [&](size_t i) {
      Piece& piece = pieces[i];
      piece.bins.add(place(ranges[piece.range]) + piece.first, piece.count, maps[piece.range]);
    });
    std::vector<Bins> sums;
    std::vector<Split> splits;
    for (const BinMap& map : maps) sums.emplace_back(map.bins);
    for (const Piece& piece : pieces) sums[piece.range].add(piece.bins, maps[piece.range].bins);
    for (size_t i = 0; i < ranges.size(); ++i) splits.push_back(sums[i].best_split(maps[i].bins));
    std::vector<std::pair<uint32_t, uint32_t>> next;
    for (const Split& split : splits) next.emplace_back(0, split.left_count);
    for (Piece& piece : pieces) {
      const Split& split = splits[piece.range];
      if (split.axis < 0) continue;
      auto& [left, right] = next[piece.range];
      const uint32_t lefts = piece.bins.count_below(split.axis, split.bin);
      piece.left = left, piece.right = right;
      left += lefts, right += piece.count - lefts;
    }
    for_all(pieces.size(), [&](size_t i) {
      Piece& piece = pieces[i];
      const Range& range = ranges[piece.range];
      const Split& split = splits[piece.range];
      BoundedTriangle* const to = other_place(range);
      if (split.axis >= 0)
        piece.centres = partition(place(range) + piece.first, piece.count, maps[piece.range], split, to + piece.left,
                                  to + piece.right);
    });
    std::vector<SideCentres> centres(ranges.size());
    for (const Piece& piece : pieces) centres[piece.range].add(piece.centres);
    std::vector<Range> large;
    for (size_t i = 0; i < ranges.size(); ++i) {
      if (splits[i].axis < 0) {
        small.push_back(ranges[i]);
        continue;
      }
      for (const Range& part : parts(ranges[i], splits[i], centres[i]))
        (part.count > built_alone && part.depth < max_sah_depth ? large : small).push_back(part);
    }
    return large;
  }

  /// Writes the node of a range that has been partitioned, and returns the two parts.
  std::array<Range, 2> parts(const Range& range, const Split& split, const SideCentres& centres) {
    const uint32_t left = split.left_count;
    write_node(range, left);
    return {{{range.node + 1, range.first, left, range.depth + 1, !range.swapped, split.left, centres.left},
             {range.node + left, range.first + left, range.count - left, range.depth + 1, !range.swapped, split.right,
              centres.right}}};
  }

  /// Returns the node behind the last one that the range uses.
  uint32_t build(const Range& range) {
    if (range.count <= few_)
      return FewTriangles(place(range), range.count, out_.undivided)
          .build(out_.nodes.data(), range.node, &out_.triangles[range.first]);
    auto [left, right] = range.depth < max_sah_depth ? split(range) : halve(range);
    right.node = build(left);
    out_.nodes[range.node].right = right.node;
    return build(right);
  }

  std::array<Range, 2> split(const Range& range) {
    const BinMap map(range.centres, range.count);
    Bins bins(map.bins);
    bins.add(place(range), range.count, map);
    const Split best = bins.best_split(map.bins);
    if (best.axis < 0) return halves(range);
    BoundedTriangle* const to = other_place(range);
    return parts(range, best, partition(place(range), range.count, map, best, to, to + best.left_count));
  }

  /// Divides the range in the middle.
  std::array<Range, 2> halves(const Range& range) {
    const uint32_t left = range.count / 2;
    write_node(range, left);
    std::array<Range, 2> result = {
        {{range.node + 1, range.first, left, range.depth + 1, range.swapped, {}, {}},
         {range.node + left, range.first + left, range.count - left, range.depth + 1, range.swapped, {}, {}}}};
    for (Range& half : result) find_boxes(half);
    return result;
  }

  /// Halves the range at the median of the widest axis.
  std::array<Range, 2> halve(const Range& range) {
    const Lanes extent = range.centres.size();
    int axis = 0;
    for (int other = 1; other < 3; ++other)
      if (extent[other] > extent[axis]) axis = other;
    BoundedTriangle* const begin = place(range);
    std::nth_element(begin, begin + range.count / 2, begin + range.count,
                     [&](const BoundedTriangle& a, const BoundedTriangle& b) {
                       const float x = a.lower[axis] - a.negated_upper[axis], y = b.lower[axis] - b.negated_upper[axis];
                       return x != y ? x < y : a.triangle < b.triangle;
                     });
    return halves(range);
  }

  BinaryBvh& out_;
  LargeArray<BoundedTriangle> other_;
  uint32_t few_;
  unsigned threads_;
};

}  // namespace

BinaryBvh build_binary_bvh(LargeArray<BoundedTriangle> triangles, uint32_t leaf_size, unsigned threads) {
  BinaryBvh result;
  result.undivided = std::max(1u, 3 * leaf_size / 8);
  if (triangles.empty()) return result;
  result.nodes.resize(std::max<size_t>(1, triangles.size() - 1));
  result.triangles = std::move(triangles);
  Builder(result, leaf_size, threads).build();
  return result;
}

}  // namespace lucarium
