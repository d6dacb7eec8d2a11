// SPDX-License-Identifier: Apache-2.0
// Which triangles a hierarchy holds. Declared in build.h.
#include <algorithm>
#include <cmath>

#include "lucarium/base/parallel.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/services/bvh/box_lanes.h"
#include "lucarium/services/bvh/build.h"

namespace lucarium {

namespace {

constexpr uint32_t bound_chunk = 8192;  // triangles that a thread takes at a time

Lanes magnitude(Lanes value) {
  return reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(value) & splat_int(0x7fffffff));
}

bool any_of_three(IntLanes mask) { return (mask[0] | mask[1] | mask[2]) != 0; }

/// Whether two products of the edges differ by far more than what rounding does to them: not is_degenerate(), then.
bool has_plain_area(Lanes a, Lanes b, Lanes c) {
  const Lanes u = b - a, v = c - a;
  const Lanes first = __builtin_shufflevector(u, u, 1, 2, 0, 3) * __builtin_shufflevector(v, v, 2, 0, 1, 3);
  const Lanes second = __builtin_shufflevector(u, u, 2, 0, 1, 3) * __builtin_shufflevector(v, v, 1, 2, 0, 3);
  // The least difference keeps off numbers so small that they are rounded more.
  const Lanes rounding = splat(1e-5f) * (magnitude(first) + magnitude(second)) + splat(1e-30f);
  return any_of_three(magnitude(first - second) > rounding);
}

bool bound(std::span<const Vertex> vertices, const Triangle& triangle, BoxLanes& box) {
  const size_t count = vertices.size();
  if (triangle.v0 >= count || triangle.v1 >= count || triangle.v2 >= count) return false;
  const Vertex &a = vertices[triangle.v0], &b = vertices[triangle.v1], &c = vertices[triangle.v2];
  const Lanes pa = load_position(a), pb = load_position(b), pc = load_position(c);
  const Lanes limit = splat(bvh_coordinate_limit);
  const IntLanes inside = (magnitude(pa) <= limit) & (magnitude(pb) <= limit) & (magnitude(pc) <= limit);
  if (any_of_three(~inside)) return false;
  const Lanes zero = {};  // of which adding makes no zero negative: a minimum keeps either zero
  box.lower = min(min(pa, pb), pc) + zero;
  box.negated_upper = min(min(zero - pa, zero - pb), zero - pc);
  return has_plain_area(pa, pb, pc) || !is_degenerate(a, b, c);
}

}  // namespace

bool bound_triangle(std::span<const Vertex> vertices, const Triangle& triangle, Bounds& box) {
  BoxLanes lanes;
  const bool usable = bound(vertices, triangle, lanes);
  box = usable ? lanes.box() : Bounds();
  return usable;
}

void bound_triangles(std::span<const Vertex> vertices, std::span<const Triangle> triangles, uint32_t first,
                     uint32_t count, unsigned threads, LargeArray<BoundedTriangle>& bounded,
                     std::vector<uint32_t>& ignored) {
  const size_t begin = bounded.size(), chunks = (count + size_t{bound_chunk} - 1) / bound_chunk;
  bounded.resize(begin + count);
  std::vector<std::vector<uint32_t>> ignored_of(chunks);
  parallel_jobs(
      chunks, std::min(threads, static_cast<unsigned>(chunks)),
      [&] {
        return [&](size_t job) {
          const uint32_t end = std::min(count, (static_cast<uint32_t>(job) + 1) * bound_chunk);
          BoundedTriangle* to = &bounded[begin + job * bound_chunk];
          for (uint32_t i = static_cast<uint32_t>(job) * bound_chunk; i < end; ++i) {
            BoxLanes box;
            if (!bound(vertices, triangles[first + i], box)) {
              ignored_of[job].push_back(first + i);
              continue;
            }
            box.store(*to);
            to->triangle = to->triangle_again = first + i;
            ++to;
          }
        };
      },
      [](size_t) {});
  // Closes the gaps behind chunks that had triangles to ignore.
  size_t gap = 0;
  for (size_t job = 0; job < chunks; ++job) {
    const size_t from = begin + job * bound_chunk, here = std::min<size_t>(bound_chunk, count - job * bound_chunk);
    if (gap > 0) std::copy_n(bounded.begin() + from, here - ignored_of[job].size(), bounded.begin() + (from - gap));
    gap += ignored_of[job].size();
    ignored.insert(ignored.end(), ignored_of[job].begin(), ignored_of[job].end());
  }
  bounded.resize(begin + count - gap);
}

}  // namespace lucarium
