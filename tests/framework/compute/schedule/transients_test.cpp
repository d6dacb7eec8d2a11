// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "lucarium/compute/schedule/transient_plan.h"

using namespace lucarium;

namespace {

/// The most bytes that are alive at one step: no plan can need less.
size_t peak_bytes(const std::vector<LiveRange>& lives, const std::vector<size_t>& bytes, int steps) {
  size_t peak = 0;
  for (int step = 0; step < steps; ++step) {
    size_t alive = 0;
    for (size_t i = 0; i < lives.size(); ++i) alive += lives[i].first <= step && step <= lives[i].last ? bytes[i] : 0;
    peak = std::max(peak, alive);
  }
  return peak;
}

}  // namespace

TEST_CASE("a life spans first to last use, and a discard begins a new one") {
  const std::vector<TransientUse> uses = {{0, 0, true}, {1, 1, false}, {2, 0, false},
                                          {5, 0, true}, {6, 0, false}, {7, 1, true}};
  const std::vector<LiveRange> lives = compute_live_ranges(uses, {false, true});
  REQUIRE(lives.size() == 3);
  CHECK((lives[0].transient == 0 && lives[0].first == 0 && lives[0].last == 2));
  CHECK((lives[1].transient == 1 && lives[1].first == 1 && lives[1].last == 7));
  CHECK((lives[2].transient == 0 && lives[2].first == 5 && lives[2].last == 6));
}

TEST_CASE("a chain of equal transients needs two of them") {
  std::vector<LiveRange> lives;
  for (int i = 0; i < 10; ++i) lives.push_back({i, i, i + 1});
  const ArenaPlan plan = place_lives(lives, std::vector<size_t>(10, 1024), 128, 1 << 20);
  REQUIRE(plan.arena_bytes.size() == 1);
  CHECK(plan.arena_bytes[0] == 2048);
  for (size_t i = 0; i < lives.size(); ++i) CHECK(plan.placements[i].offset == (i % 2 ? 1024 : 0));
  const std::vector<int> slots = assign_slots(lives);
  CHECK(*std::max_element(slots.begin(), slots.end()) == 1);
}

TEST_CASE("random lives: aligned, below the limit, never overlapping in time and space, near the lower bound") {
  std::mt19937 random(2);
  double planned = 0, unavoidable = 0, unshared = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int steps = 40;
    const size_t alignment = 128, limit = 16384;
    std::vector<LiveRange> lives;
    std::vector<size_t> bytes;
    for (int i = 0; i < 30; ++i) {
      const int first = static_cast<int>(random() % steps);
      lives.push_back({i, first, std::min(steps - 1, first + static_cast<int>(random() % 8))});
      bytes.push_back(alignment * (1 + random() % 20));
    }
    const ArenaPlan plan = place_lives(lives, bytes, alignment, limit);
    for (const size_t arena : plan.arena_bytes) REQUIRE(arena <= limit);
    for (size_t a = 0; a < lives.size(); ++a) {
      const Placement& place = plan.placements[a];
      REQUIRE(place.offset % alignment == 0);
      REQUIRE(place.offset + bytes[a] <= plan.arena_bytes[static_cast<size_t>(place.arena)]);
      for (size_t b = 0; b < a; ++b) {
        const Placement& other = plan.placements[b];
        const bool same_bytes = place.arena == other.arena && place.offset < other.offset + bytes[b] &&
                                other.offset < place.offset + bytes[a];
        REQUIRE_FALSE((same_bytes && lives[a].overlaps(lives[b])));
      }
      unshared += static_cast<double>(bytes[a]);
    }
    for (const size_t arena : plan.arena_bytes) planned += static_cast<double>(arena);
    unavoidable += static_cast<double>(peak_bytes(lives, bytes, steps));

    const std::vector<int> slots = assign_slots(lives);
    const ArenaPlan apart = place_lives_apart(lives, bytes);
    for (size_t a = 0; a < lives.size(); ++a) {
      REQUIRE(apart.placements[a].arena == slots[a]);
      REQUIRE(apart.placements[a].offset == 0);
      REQUIRE(bytes[a] <= apart.arena_bytes[static_cast<size_t>(slots[a])]);
      for (size_t b = 0; b < a; ++b) REQUIRE_FALSE((slots[a] == slots[b] && lives[a].overlaps(lives[b])));
    }
    const size_t fewest = peak_bytes(lives, std::vector<size_t>(lives.size(), 1), steps);
    REQUIRE(static_cast<size_t>(*std::max_element(slots.begin(), slots.end())) + 1 == fewest);
  }
  CHECK(planned < 1.25 * unavoidable);
  CHECK(planned < 0.6 * unshared);
}

TEST_CASE("lives go to further arenas when one is full") {
  const std::vector<LiveRange> lives = {{0, 0, 3}, {1, 0, 3}, {2, 0, 3}};
  const ArenaPlan plan = place_lives(lives, {1000, 1000, 1000}, 128, 2048);
  CHECK(plan.arena_bytes.size() == 2);
}
