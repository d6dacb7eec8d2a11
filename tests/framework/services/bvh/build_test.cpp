// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <bit>
#include <limits>
#include <set>

#include "lucarium/services/bvh/wide.h"
#include "tolerance.h"
#include "triangle_soups.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

WideBvh build(const Soup& soup, int width, int leaf_size, unsigned threads = 2) {
  LargeArray<BoundedTriangle> bounded;
  std::vector<uint32_t> ignored;
  bound_triangles(soup.vertices, soup.triangles, 0, static_cast<uint32_t>(soup.triangles.size()), threads, bounded,
                  ignored);
  CHECK(bounded.size() + ignored.size() == soup.triangles.size());
  return {build_binary_bvh(std::move(bounded), static_cast<uint32_t>(leaf_size), threads),
          width,
          leaf_size,
          {soup.vertices, soup.triangles},
          threads};
}

/// Walks a tree as a traversal kernel that misses nothing would.
struct Walk {
  const WideBvh& tree;
  const Soup& soup;
  std::set<uint32_t> found = {};
  uint32_t references = 0;

  Bounds visit(uint32_t node) {
    const auto width = static_cast<uint32_t>(tree.width());
    const uint32_t* words = &tree.node_words()[LUCARIUM_BVH_HEADER_WORDS + node * LUCARIUM_BVH_NODE_WORDS(width)];
    Bounds all;
    for (uint32_t slot = 0; slot < width; ++slot) {
      Bounds stored;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        stored.min[axis] = std::bit_cast<float>(words[axis * width + slot]);
        stored.max[axis] = std::bit_cast<float>(words[LUCARIUM_BVH_UPPER(width) + axis * width + slot]);
      }
      const uint32_t reference = words[LUCARIUM_BVH_NODE_REFERENCES(width) + slot];
      if (stored.min[0] > stored.max[0]) {
        CHECK(reference == 0xffffffffu);
        continue;
      }
      ++references;
      const uint32_t block = reference & ~LUCARIUM_BVH_LEAF;
      const Bounds below = block != reference
                               ? leaf(block)
                               : inner(node, (reference - LUCARIUM_BVH_ROOT) / LUCARIUM_BVH_NODE_WORDS(width));
      CHECK(below.min == stored.min);
      CHECK(below.max == stored.max);
      all.add(stored);
    }
    return all;
  }

  Bounds inner(uint32_t parent, uint32_t node) {
    CHECK(node > parent);
    return visit(node);
  }

  Bounds leaf(uint32_t block) {
    const auto size = static_cast<uint32_t>(tree.leaf_size());
    const uint32_t* words = &tree.block_words()[block];
    Bounds box;
    for (uint32_t slot = 0; slot < size; ++slot) {
      const uint32_t triangle = words[LUCARIUM_BVH_BLOCK_TRIANGLES(size) + slot];
      if (triangle == LUCARIUM_NO_HIT) continue;
      CHECK(found.insert(triangle).second);
      Bounds own;
      CHECK(bound_triangle(soup.vertices, soup.triangles[triangle], own));
      box.add(own);
      CHECK(std::bit_cast<float>(words[slot]) == soup.corner(soup.triangles[triangle].v0).x);
      CHECK(std::bit_cast<float>(words[8 * size + slot]) == soup.corner(soup.triangles[triangle].v2).z);
    }
    return box;
  }
};

void check_structure(const Soup& soup, size_t expected_triangles) {
  for (const auto& [width, leaf_size] : {std::pair{16, 8}, {8, 4}, {4, 4}}) {
    const WideBvh tree = build(soup, width, leaf_size);
    Walk walk{tree, soup};
    walk.visit(0);
    CHECK(walk.found.size() == expected_triangles);
    // Every node but the root and every block is referred to exactly once.
    CHECK(walk.references == tree.node_count() - 1 + tree.block_count());
    CHECK(tree.node_words().size() ==
          LUCARIUM_BVH_HEADER_WORDS + tree.node_count() * LUCARIUM_BVH_NODE_WORDS(static_cast<uint32_t>(width)));
  }
}

}  // namespace

TEST_CASE("every triangle lies in one leaf, inside every box above it") {
  for (const uint32_t count : {0u, 1u, 2u, 7u, 8u, 9u, 17u, 129u, 5000u})
    check_structure(random_soup(count, count + 1), count);
}

TEST_CASE("the hierarchy does not depend on the number of threads") {
  // Threads share the largest ranges; coinciding centres cannot be divided by bins.
  Soup coinciding;
  for (int i = 0; i < 40000; ++i) coinciding.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const Soup& soup : {random_soup(30000, 7), rough_sphere(200, 150, 3), coinciding}) {
    const WideBvh one = build(soup, 16, 8, 1);
    for (const unsigned threads : {2u, 5u}) {
      const WideBvh other = build(soup, 16, 8, threads);
      CHECK(other.node_words() == one.node_words());
      CHECK(other.block_words() == one.block_words());
    }
  }
}

TEST_CASE("zeros of either sign make the same hierarchy") {
  Soup plus, minus;
  Random random(12);
  for (int i = 0; i < 20000; ++i) {
    const glm::vec2 a(random.in_cube(5)), b(random.in_cube(5));
    plus.add_triangle({0.f, a}, {0.f, b}, {1.f, a});
    minus.add_triangle({i % 3 ? -0.f : 0.f, a}, {i % 2 ? -0.f : 0.f, b}, {1.f, a});
  }
  const WideBvh tree = build(plus, 16, 8);
  for (const unsigned threads : {1u, 2u}) CHECK(build(minus, 16, 8, threads).node_words() == tree.node_words());
}

TEST_CASE("a wide hierarchy has the boxes that fitting it gives") {
  for (const auto& [width, leaf_size] : {std::pair{16, 8}, {8, 4}, {4, 4}}) {
    const Soup soup = random_soup(3000, 6);
    const WideBvh tree = build(soup, width, leaf_size);
    WideBvh fitted = tree;
    fitted.fit(soup.vertices, soup.triangles);
    CHECK(fitted.node_words() == tree.node_words());
    CHECK(fitted.block_words() == tree.block_words());
    CHECK(fitted.sah_cost() == relative(tree.sah_cost()));
    CHECK(fitted.dead_count() == 0);
  }
}

TEST_CASE("triangles that nothing can hit are left out") {
  Soup soup = random_soup(20, 3);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = INFINITY;
  soup.add_triangle({0, 0, 0}, {nan, 1, 0}, {1, 0, 0});
  soup.add_triangle({0, infinity, 0}, {0, 1, 0}, {1, 0, 0});
  soup.add_triangle({0, 0, 0}, {0, 1e20f, 0}, {1, 0, 0});
  soup.add_triangle({1, 2, 3}, {1, 2, 3}, {1, 2, 3});
  soup.add_triangle({0, 0, 0}, {1, 1, 1}, {3, 3, 3});
  soup.triangles.push_back({0, 1, 0xfffffff0u, 0});
  check_structure(soup, 20);
}

TEST_CASE("coinciding and nested triangles make shallow trees") {
  Soup same, nested;
  for (int i = 0; i < 3000; ++i) same.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  // Sizes that shrink geometrically are what makes surface-area splits degenerate into a list.
  for (int i = 0; i < 3000; ++i) {
    const float size = std::pow(0.98f, static_cast<float>(i));
    nested.add_triangle({0, 0, 0}, {size, 0, 0}, {0, size, 0});
  }
  check_structure(same, 3000);
  check_structure(nested, 3000);
  CHECK(build(same, 16, 8).stack_size() < 128);
  CHECK(build(nested, 16, 8).stack_size() < 400);
}

TEST_CASE("refitting gives the boxes of the moved triangles") {
  Soup soup = random_soup(2000, 5);
  WideBvh tree = build(soup, 16, 8);
  const double before = tree.sah_cost();
  for (Vertex& vertex : soup.vertices) vertex.position.x = 3 * vertex.position.x + 1;
  tree.fit(soup.vertices, soup.triangles);
  Walk walk{tree, soup};
  walk.visit(0);
  CHECK(walk.found.size() == 2000);
  // Scrambled positions ruin the tree, and its cost says so.
  Random random(9);
  for (Triangle& triangle : soup.triangles) {
    const glm::vec3 shift = random.in_cube(20);
    for (const uint32_t vertex : {triangle.v0, triangle.v1, triangle.v2})
      soup.vertices[vertex].position = float4(soup.corner(vertex) + shift, 0.f);
  }
  tree.fit(soup.vertices, soup.triangles);
  CHECK(tree.sah_cost() > 1.5 * before);
}

TEST_CASE("the byte estimate is an upper one for ordinary geometry") {
  for (const Soup& soup : {random_soup(10000, 1), rough_sphere(60, 90, 2)}) {
    const WideBvh tree = build(soup, 16, 8);
    const size_t bytes = 4 * (tree.node_words().size() + tree.block_words().size());
    const size_t estimate = WideBvh::estimate_bytes(soup.triangles.size(), 16, 8);
    CHECK(bytes <= estimate);
    CHECK(estimate < 4 * bytes);
  }
}
