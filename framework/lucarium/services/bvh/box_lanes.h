// SPDX-License-Identifier: Apache-2.0
// Boxes in vectors of four floats, for the builds of hierarchies.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "lucarium/scene/bounds.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

using Lanes = float __attribute__((vector_size(16)));
using IntLanes = int32_t __attribute__((vector_size(16)));

inline Lanes splat(float value) { return Lanes{value, value, value, value}; }
inline IntLanes splat_int(int32_t value) { return IntLanes{value, value, value, value}; }
inline Lanes min(Lanes a, Lanes b) { return a < b ? a : b; }

inline Lanes load_position(const Vertex& vertex) {
  Lanes lanes;
  static_assert(offsetof(Vertex, position) == 0 && sizeof(vertex.position) == sizeof(lanes));
  std::memcpy(&lanes, &vertex, sizeof(lanes));
  return lanes;
}

struct PointsInLanes {
  Lanes x, y, z;
};
inline PointsInLanes transposed(Lanes a, Lanes b, Lanes c, Lanes d) {
  const Lanes low = __builtin_shufflevector(a, b, 0, 4, 1, 5), low2 = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Lanes high = __builtin_shufflevector(a, b, 2, 6, 3, 7), high2 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return {__builtin_shufflevector(low, low2, 0, 1, 4, 5), __builtin_shufflevector(low, low2, 2, 3, 6, 7),
          __builtin_shufflevector(high, high2, 0, 1, 4, 5)};
}

/// The first three lanes of each are a box; what the fourth hold means nothing.
struct BoxLanes {
  Lanes lower, negated_upper;

  BoxLanes() = default;  // undefined; see empty()
  BoxLanes(Lanes low, Lanes negated_up) : lower(low), negated_upper(negated_up) {}
  /// From a record of 32 bytes that begins like a BoundedTriangle.
  template <class Record>
  explicit BoxLanes(const Record& record) {
    static_assert(sizeof(Record) == 32 && alignof(Record) == 16);
    std::memcpy(&lower, record.lower, sizeof(lower));
    std::memcpy(&negated_upper, record.negated_upper, sizeof(negated_upper));
  }
  template <class Record>
  void store(Record& record) const {
    std::memcpy(record.lower, &lower, sizeof(lower));
    std::memcpy(record.negated_upper, &negated_upper, sizeof(negated_upper));
  }
  static BoxLanes empty() { return {splat(1e30f), splat(1e30f)}; }

  void add(const BoxLanes& other) {
    lower = min(other.lower, lower);
    negated_upper = min(other.negated_upper, negated_upper);
  }
  Lanes centre2() const { return lower - negated_upper; }  ///< twice the centre
  Lanes size() const { return -(lower + negated_upper); }
  /// No upper bound is a negative zero, whichever zero the minimum has kept.
  Bounds box() const {
    return {{lower[0], lower[1], lower[2]}, {0.f - negated_upper[0], 0.f - negated_upper[1], 0.f - negated_upper[2]}};
  }
};

inline BoxLanes joined(BoxLanes a, const BoxLanes& b) {
  a.add(b);
  return a;
}

/// Half the areas of three boxes, one a lane; the fourth means nothing. Infinite for empty ones.
inline Lanes half_areas(const BoxLanes& a, const BoxLanes& b, const BoxLanes& c) {
  // The fourth lanes are cut off: products of tiny numbers, as which they may count, are slow on some processors.
  constexpr IntLanes three = {-1, -1, -1, 0};
  const auto products = [&](const BoxLanes& box) {
    const Lanes size = reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(box.lower + box.negated_upper) & three);
    return size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
  };
  const Lanes pa = products(a), pb = products(b), pc = products(c);
  const Lanes low = __builtin_shufflevector(pa, pb, 0, 4, 1, 5), high = __builtin_shufflevector(pa, pb, 2, 6, 3, 7);
  return __builtin_shufflevector(low, pc, 0, 1, 4, 4) + __builtin_shufflevector(low, pc, 2, 3, 5, 5) +
         __builtin_shufflevector(high, pc, 0, 1, 6, 6);
}
inline float half_area(const BoxLanes& box) {
  const Lanes size = box.lower + box.negated_upper;
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

}  // namespace lucarium
