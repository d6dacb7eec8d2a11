// SPDX-License-Identifier: Apache-2.0
// Which candidate is farthest from the points found so far.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "lucarium/services/large_array.h"

namespace lucarium::micro {

/// Points and the normals of their surfaces, in a hash grid whose cells hold chains. Cells that are neighbours stand
/// together, in blocks of 4³, and memory is asked for before it is looked at: most of the time goes to waiting for it.
class PointGrid {
 public:
  explicit PointGrid(uint32_t capacity) : points_(capacity) {}

  /// Empties the grid and puts points [0, count) into cells of this size.
  void rebuild(uint32_t count, float cell) {
    cell_ = std::max(cell, 1e-30f);  // 0: surfaces without area
    inverse_ = 1 / cell_;
    heads_.assign(std::bit_ceil(size_t{4} * count + block_cells), no_point);
    block_mask_ = static_cast<uint32_t>(heads_.size() / block_cells - 1);
    for (uint32_t i = 0; i < count; ++i) insert(i);
  }
  /// Point i is seen from its insert() on; set() comes before it, from any thread.
  void set(uint32_t i, const glm::vec3& position, const glm::vec3& normal) {
    points_[i].position = position, points_[i].normal = normal;
  }
  void insert(uint32_t i) {
    uint32_t& head = heads_[chain_of(cell_of(points_[i].position))];
    points_[i].next = head;
    head = i;
  }

  /// A candidate, and what is known of its distance.
  struct Look {
    glm::vec3 position, normal;
    glm::ivec3 cell;
    uint32_t chain;   ///< of its own cell
    float distance2;  ///< squared, to the nearest point, an upper bound
  };
  Look look_from(const glm::vec3& position, const glm::vec3& normal) const {
    const glm::ivec3 cell = cell_of(position);
    const Look look{position, normal, cell, chain_of(cell), cell_ * cell_};
    __builtin_prefetch(&heads_[look.chain]);
    return look;
  }

  /// The candidate whose nearest point is farthest, the first of several. Distances are no larger than a cell; points
  /// whose normals differ count as farther, and those of other layers, so that both sides of a thin sheet are covered
  /// by their own.
  template <size_t number>
  size_t farthest(std::array<Look, number>& looks) const {
    for (const Look& look : looks) prefetch_point(heads_[look.chain]);
    for (Look& look : looks) look_along(look, heads_[look.chain], 0);
    // Always the one that promises most, until no other can be farther.
    size_t best = number;
    float best2 = -1;
    std::array<bool, number> done{};
    while (true) {
      size_t next = number;
      for (size_t k = 0; k < number; ++k)
        if (!done[k] && (next == number || looks[k].distance2 > looks[next].distance2)) next = k;
      if (next == number || looks[next].distance2 < best2) return best;
      done[next] = true;
      look_around(looks[next], std::nextafter(best2, -1.f));  // of one that is as far the number decides
      const float distance2 = looks[next].distance2;
      if (distance2 > best2 || (distance2 == best2 && next < best)) best = next, best2 = distance2;
    }
  }

 private:
  static constexpr uint32_t no_point = 0xffffffffu;  // ends chains
  static constexpr uint32_t block_cells = 64;
  /// How much farther a point counts that lies before or behind another: parallel layers leave each other alone.
  static constexpr float apart = 8;

  struct alignas(32) Point {
    glm::vec3 position;
    uint32_t next;
    glm::vec3 normal;
  };

  /// The 26 cells about one, as offsets + 1, the nearest first.
  static constexpr std::array<std::array<uint8_t, 3>, 26> around = [] {
    std::array<std::array<uint8_t, 3>, 26> list{};
    size_t count = 0;
    for (int order = 1; order <= 3; ++order) {
      for (int i = 0; i < 27; ++i) {
        const int x = i % 3, y = i / 3 % 3, z = i / 9;
        if ((x != 1) + (y != 1) + (z != 1) == order)
          list[count++] = {static_cast<uint8_t>(x), static_cast<uint8_t>(y), static_cast<uint8_t>(z)};
      }
    }
    return list;
  }();

  glm::ivec3 cell_of(const glm::vec3& p) const {
    constexpr float far = 1 << 30;  // within int, neighbours too
    const glm::vec3 place = glm::clamp(p * inverse_, -far, far);
    glm::ivec3 cell(place);
    for (int axis = 0; axis < 3; ++axis) cell[axis] -= static_cast<float>(cell[axis]) > place[axis];
    return cell;
  }
  /// By axis, what makes a cell's place in its block, and the block's place.
  static uint32_t place_in_block(int c, int axis) { return (static_cast<uint32_t>(c) & 3u) << 2 * axis; }
  static uint32_t hash_of_block(int c, int axis) {
    constexpr uint32_t factors[] = {73856093u, 19349663u, 83492791u};
    return static_cast<uint32_t>(c >> 2) * factors[axis];
  }
  uint32_t first_of_block(uint32_t hash) const {
    hash ^= hash >> 15;
    return ((hash * 2654435761u >> 3) & block_mask_) * block_cells;
  }
  uint32_t chain_of(const glm::ivec3& cell) const {
    return first_of_block(hash_of_block(cell.x, 0) ^ hash_of_block(cell.y, 1) ^ hash_of_block(cell.z, 2)) |
           place_in_block(cell.x, 0) | place_in_block(cell.y, 1) | place_in_block(cell.z, 2);
  }

  void prefetch_point(uint32_t first) const { __builtin_prefetch(points_.data() + (first == no_point ? 0 : first)); }

  /// Looks at a point and those behind it in its chain; false once one is as near as `enough2`.
  [[gnu::always_inline]] bool look_along(Look& look, uint32_t first, float enough2) const {
    for (uint32_t i = first; i != no_point; i = points_[i].next) {
      const glm::vec3 d = points_[i].position - look.position;
      const float d2 = glm::dot(d, d);
      if (d2 >= look.distance2) continue;
      const float stretch = 1 + 2 * (1 - std::max(0.f, glm::dot(points_[i].normal, look.normal)));
      const float height = apart * glm::dot(d, look.normal);
      look.distance2 = std::min(look.distance2, d2 * stretch * stretch + height * height);
      if (look.distance2 <= enough2) return false;
    }
    return true;
  }

  /// Looks at the points of the 26 cells about the candidate's own, until one is as near as `enough2`.
  void look_around(Look& look, float enough2) const {
    // By axis and offset + 1: squared distance to a cell, height of its middle over the surface, and its place.
    float gap2[3][3], height[3][3], reach = 0;
    uint32_t hash[3][3], place[3][3];
    for (int axis = 0; axis < 3; ++axis) {
      const float low = look.position[axis] - static_cast<float>(look.cell[axis]) * cell_, high = cell_ - low;
      gap2[axis][0] = low * low, gap2[axis][1] = 0, gap2[axis][2] = high * high;
      for (int o = 0; o < 3; ++o) {
        height[axis][o] = look.normal[axis] * ((static_cast<float>(o) - 0.5f) * cell_ - low);
        place[axis][o] = place_in_block(look.cell[axis] + o - 1, axis);
        hash[axis][o] = hash_of_block(look.cell[axis] + o - 1, axis);
      }
      reach += std::abs(look.normal[axis]);
    }
    reach *= 0.501f * cell_;  // half a cell, and what rounding may add
    // What lies in a cell is at least as far as the cell, and as high over the surface. Cells that may matter are
    // listed first, so that their memory is waited for but once.
    struct Cell {
      float distance2;
      uint32_t chain;
    };
    Cell cells[around.size()];
    size_t count = 0;
    for (const auto& [x, y, z] : around) {
      const float above = apart * std::max(0.f, std::abs(height[0][x] + height[1][y] + height[2][z]) - reach);
      const float distance2 = gap2[0][x] + gap2[1][y] + gap2[2][z] + above * above;
      const uint32_t block = first_of_block(hash[0][x] ^ hash[1][y] ^ hash[2][z]);
      cells[count] = {distance2, block | place[0][x] | place[1][y] | place[2][z]};
      count += distance2 < look.distance2;  // no branch: which cells matter is hard to foretell
    }
    for (size_t i = 0; i < count; ++i) __builtin_prefetch(&heads_[cells[i].chain]);
    size_t filled = 0;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t first = heads_[cells[i].chain];
      cells[filled] = {cells[i].distance2, first};
      filled += first != no_point;
      prefetch_point(first);
    }
    for (size_t i = 0; i < filled; ++i)
      if (cells[i].distance2 < look.distance2 && !look_along(look, cells[i].chain, enough2)) return;
  }

  float cell_ = 1, inverse_ = 1;
  uint32_t block_mask_ = 0;
  LargeArray<uint32_t> heads_;  ///< of chains
  LargeArray<Point> points_;
};

}  // namespace lucarium::micro
