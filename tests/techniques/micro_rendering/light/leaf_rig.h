// SPDX-License-Identifier: Apache-2.0
// Light at the leaves of a scene's forest, without the technique around it.
#pragma once
#include <vector>

#include "device_fixture.h"
#include "lucarium/services/bvh/bvh.h"
#include "micro_rendering/light/leaf_light.h"
#include "tree/packed_node.h"

namespace lucarium::test {

struct LeafRig {
  struct Leaf {
    glm::dvec3 position;  ///< in the world
    glm::vec3 normal;
    float radius;  ///< [grid steps]
  };

  LeafRig(const Scene& host_scene, const micro::MicroParameters& given) : scene(host_scene), parameters(given) {}

  /// Steps that bring light of that many bounces to the leaves.
  micro::LeafLight light(int bounces) {
    return {device, scheduler, scene, buffers, bvh, forest, gather, parameters, bounces, "test"};
  }

  /// Light at the leaves without what nodes gather, samples of `frame`.
  std::vector<float4> receive(micro::LeafLight& light, uint32_t frame, uint32_t seed) {
    REQUIRE(light.receive(frame, seed));
    scheduler.finish();
    return light.received().download();
  }

  /// Goes on with `received` instead of what receive() has brought.
  void spread(micro::LeafLight& light, const std::vector<float4>& received) {
    light.received().write(received.data(), received.size() * sizeof(float4));
    REQUIRE(light.spread());
    scheduler.finish();
  }

  /// Those of the first tree, in its order.
  std::vector<Leaf> leaves() const {
    const std::vector<uint4> nodes = forest.nodes.download();
    const MicroTree& tree = forest.trees().front().record;
    std::vector<Leaf> list;
    for (uint32_t k = 0; k < forest.leaf_count(); ++k) {
      const PackedNode node = unpack(nodes[forest.leaf_count() + k]);
      list.push_back({glm::dvec3(tree.origin_step.xyz()) + double{tree.origin_step.w} * glm::dvec3(node.center),
                      node.normal, node.radius});
    }
    return list;
  }

  const Scene& scene;
  micro::MicroParameters parameters;
  Device& device = *test_device();
  KernelScheduler scheduler{device.shared_from_this()};
  SceneBuffers buffers{device, scene};
  Bvh bvh{device, scene, buffers};
  micro::PointForest forest{device, scheduler, scene, buffers, {.points_log2 = parameters.points_log2}, "test"};
  micro::GatherPass gather{device, parameters, micro::GatherAt::nodes};
};

}  // namespace lucarium::test
