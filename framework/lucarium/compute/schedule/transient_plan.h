// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

namespace lucarium {

/// One step's use of a transient.
struct TransientUse {
  int step = 0;
  int transient = 0;
  bool discards = false;  ///< overwrites everything: the contents are dead before this step
};

/// Live range of a transient, the steps [first, last]. A transient that is discarded and filled again has several live
/// ranges, each with memory of its own.
struct LiveRange {
  int transient = 0;
  int first = 0, last = 0;
  bool overlaps(const LiveRange& other) const { return first <= other.last && other.first <= last; }
};

/// Lives in order of their first step. `uses` are in program order, at most one per step and transient; a transient
/// with `single_life` (by transient) is never split.
std::vector<LiveRange> compute_live_ranges(const std::vector<TransientUse>& uses, const std::vector<bool>& single_life);

/// Where a life's memory lies.
struct Placement {
  int arena = -1;
  size_t offset = 0;
};

struct ArenaPlan {
  std::vector<Placement> placements;  ///< one per life
  std::vector<size_t> arena_bytes;
};

/// Colours the interval graph of lives with byte ranges: lives that overlap in time get disjoint memory. Largest
/// first, each at the lowest offset (a multiple of `alignment`) of the first arena that has room; arenas never exceed
/// `max_arena_bytes` unless a single life does (the caller refuses that one by name). Deterministic.
ArenaPlan place_lives(const std::vector<LiveRange>& lives, const std::vector<size_t>& bytes, size_t alignment,
                      size_t max_arena_bytes);

/// The same with one life at a time in an arena, from its beginning: where parts of a buffer must not overlap.
ArenaPlan place_lives_apart(const std::vector<LiveRange>& lives, const std::vector<size_t>& bytes);

/// The same for lives whose sizes are known only at run time: the number of the buffer each one uses. The fewest
/// buffers that keep overlapping lives apart.
std::vector<int> assign_slots(const std::vector<LiveRange>& lives);

}  // namespace lucarium
