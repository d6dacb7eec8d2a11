// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/transient_plan.h"

#include <algorithm>
#include <numeric>

namespace lucarium {
namespace {

struct Range {
  size_t begin = 0, end = 0;
};

size_t round_up(size_t value, size_t multiple) { return (value + multiple - 1) / multiple * multiple; }

/// The lowest offset with `bytes` free bytes between `taken` ranges (sorted by begin).
size_t lowest_gap(const std::vector<Range>& taken, size_t bytes, size_t alignment) {
  size_t offset = 0;
  for (const Range& range : taken) {
    if (offset + bytes <= range.begin) break;
    offset = std::max(offset, round_up(range.end, alignment));
  }
  return offset;
}

}  // namespace

std::vector<LiveRange> compute_live_ranges(const std::vector<TransientUse>& uses,
                                           const std::vector<bool>& single_life) {
  std::vector<LiveRange> lives;
  std::vector<int> current(single_life.size(), -1);
  for (const TransientUse& use : uses) {
    const size_t transient = static_cast<size_t>(use.transient);
    int& life = current[transient];
    if (life < 0 || (use.discards && !single_life[transient])) {
      life = static_cast<int>(lives.size());
      lives.push_back({use.transient, use.step, use.step});
    }
    lives[static_cast<size_t>(life)].last = use.step;
  }
  return lives;
}

ArenaPlan place_lives(const std::vector<LiveRange>& lives, const std::vector<size_t>& bytes, size_t alignment,
                      size_t max_arena_bytes) {
  std::vector<size_t> order(lives.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return bytes[a] > bytes[b]; });

  ArenaPlan plan;
  plan.placements.resize(lives.size());
  std::vector<std::vector<size_t>> members;  // lives by arena
  for (const size_t life : order) {
    size_t arena = 0, offset = 0;
    for (; arena < members.size(); ++arena) {
      std::vector<Range> taken;
      for (const size_t other : members[arena]) {
        if (!lives[life].overlaps(lives[other])) continue;
        const size_t begin = plan.placements[other].offset;
        taken.push_back({begin, begin + bytes[other]});
      }
      std::sort(taken.begin(), taken.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
      offset = lowest_gap(taken, bytes[life], alignment);
      if (offset + bytes[life] <= max_arena_bytes) break;
    }
    if (arena == members.size()) {
      members.emplace_back();
      plan.arena_bytes.push_back(0);
      offset = 0;
    }
    members[arena].push_back(life);
    plan.placements[life] = {static_cast<int>(arena), offset};
    plan.arena_bytes[arena] = std::max(plan.arena_bytes[arena], offset + bytes[life]);
  }
  return plan;
}

ArenaPlan place_lives_apart(const std::vector<LiveRange>& lives, const std::vector<size_t>& bytes) {
  ArenaPlan plan;
  for (const int arena : assign_slots(lives)) {
    const auto index = static_cast<size_t>(arena);
    if (index >= plan.arena_bytes.size()) plan.arena_bytes.resize(index + 1, 0);
    plan.arena_bytes[index] = std::max(plan.arena_bytes[index], bytes[plan.placements.size()]);
    plan.placements.push_back({arena, 0});
  }
  return plan;
}

std::vector<int> assign_slots(const std::vector<LiveRange>& lives) {
  std::vector<size_t> order(lives.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return lives[a].first < lives[b].first; });
  std::vector<int> slots(lives.size(), -1), last_step;  // last_step: of each slot's present owner
  for (const size_t life : order) {
    const auto free =
        std::find_if(last_step.begin(), last_step.end(), [&](int last) { return last < lives[life].first; });
    slots[life] = static_cast<int>(free - last_step.begin());
    if (free == last_step.end()) {
      last_step.push_back(lives[life].last);
    } else {
      *free = lives[life].last;
    }
  }
  return slots;
}

}  // namespace lucarium
