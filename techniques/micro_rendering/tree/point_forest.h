// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "micro_rendering/points/scene_sides.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::micro {

struct ForestOptions {
  int points_log2 = 18;
  float disc_scale = 1.6f;    ///< radius of a leaf's disc over that of the disc of its area
  bool all_cullable = false;  ///< surfaces are transparent from behind instead of black
  bool skip_hidden = false;   ///< no points where nothing sees them (point_visibility.h); needs `intersector`
  const Intersector* intersector = nullptr;
  std::vector<int> moving;  ///< instances that have trees of their own though no animation moves them
  bool posed = false;       ///< leaves of deforming trees are ordered as they stand now, not as at rest
  int threads =
      static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));  ///< the result is the same for any number
  std::function<void(double fraction, const std::string& stage)> progress;  ///< may be empty
};

/// Tree as the host knows it.
struct ForestTree {
  TreeKind kind = TreeKind::resting;
  int instance = none;
  MicroTree record{};           ///< as on the device
  double covered = 1;           ///< covered area / plain area
  double placed_area = 0;       ///< covered area in the space in which points were placed
  double world_area = 0;        ///< covered area in the world then [m²], which decided how many points it has
  double built_radius_sum = 0;  ///< radius_sum() of the points as they were ordered: at rest, or posed
  uint32_t leaves() const { return 1u << record.depth; }
};

/// The scene as trees of discs on the device: points are placed and ordered on the host once, nodes derived and
/// refitted on the device. Owner of all memory: `owner`.
///
/// What no animation moves is one tree. Each animated instance has its own: a rigid one lies in its object's space and
/// moves by its matrix alone, one that is skinned, morphed or stretched is refitted. Its points are placed and ordered
/// on the mesh at rest, so that a frame does not depend on the frames before, unless a pose loosens the tree: then it
/// is ordered as it stands, also when a run begins there.
class PointForest {
 public:
  /// Throws Error{interrupted}.
  PointForest(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
              const ForestOptions& options, const std::string& owner);

  /// Follows moved and deformed instances and changed materials; returns false when the forest must be rebuilt
  /// (topology; something moved that rests; a deformed tree has become too loose; something has grown so much that its
  /// points no longer suffice; coverage may have changed).
  bool update(const SceneChange& change);

  bool loosened() const { return loosened_; }  ///< a deformed tree is too loose, at first or since update() failed

  const std::vector<ForestTree>& trees() const { return trees_; }
  uint32_t leaf_count() const { return leaf_count_; }  ///< of all trees

  TypedBuffer<MicroTree> tree_records;
  TypedBuffer<MicroLeaf> leaves;              ///< leaf_count()
  TypedBuffer<uint2> leaf_albedo;             ///< half4 per leaf
  TypedBuffer<uint4> nodes;                   ///< 2 leaf_count()
  TypedBuffer<uint4> clips;                   ///< leaf_count(), see micro_types.h
  TypedBuffer<TriangleEdges> triangle_edges;  ///< by world triangle
  TypedBuffer<uint2> radiance;                ///< half4 per node
  TypedBuffer<float> radiance_unit;           ///< one element [cd/m²]

  /// Share of the points that lie on details finer than their discs: beside one that faces another way by more than 60
  /// degrees.
  double fine_details() const { return fine_details_; }
  double hidden() const { return hidden_; }  ///< share of the surfaces that nothing sees
  double sampling_seconds() const { return sampling_seconds_; }
  double ordering_seconds() const { return ordering_seconds_; }
  double updating_seconds() const { return updating_seconds_; }  ///< on the device: the last leaves and nodes

  struct Size {
    size_t leaves, bytes;
  };
  /// Most leaves that a forest may have, and device bytes that it takes.
  static Size estimate(const Scene& scene, const ForestOptions& options);
  /// Calls pass(top, bottom) for a pass over inner levels [top, bottom) from the leaves of a tree up.
  template <class Pass>
  static void for_level_ranges(uint32_t depth, Pass pass) {
    constexpr uint32_t levels_per_pass = 6;
    for (uint32_t bottom = depth; bottom > 0;) {
      const uint32_t top = bottom > levels_per_pass ? bottom - levels_per_pass : 0;
      pass(top, bottom);
      bottom = top;
    }
  }
  /// Adds one pass per such range of tree number `number`: 2^top work-items of `kernel`, which has the parameters
  /// `trees`, `tree`, `top` and `bottom`, and the arguments that bind(PassBuilder&) gives.
  template <class Bind>
  void add_level_passes(ScheduleRecorder& recorder, const std::string& name, const Program& program,
                        const std::string& kernel, uint32_t number, Bind bind) const {
    for_level_ranges(trees_[number].record.depth, [&](uint32_t top, uint32_t bottom) {
      PassBuilder pass = recorder.pass(name, program, kernel);
      pass.global(size_t{1} << top).local(1);
      pass.arg("trees", tree_records).arg("tree", number).arg("top", top).arg("bottom", bottom);
      bind(pass);
    });
  }

 private:
  /// The parts of a material that decide where points are.
  struct Placing {
    AlphaMode alpha_mode;
    bool two_sided, transmits;
    bool operator==(const Placing&) const = default;
  };
  std::vector<Placing> placing() const;
  void report(double fraction, const char* stage) const;
  void place(std::vector<TreeSource> sources);
  void derive_albedo();
  void derive(const std::vector<size_t>& trees);
  void set_grid(ForestTree& tree, const TreeSource* source);
  void set_transform(ForestTree& tree) const;
  double bent_pairs() const;
  double update_seconds() const;
  double radius_sum(const ForestTree& tree) const;
  bool too_loose(const ForestTree& tree) const;
  bool outgrown(const ForestTree& tree) const;

  Device& device_;
  KernelScheduler& scheduler_;
  const Scene& scene_;
  const SceneBuffers& buffers_;
  ForestOptions options_;
  std::string owner_;
  Program program_;
  std::vector<ForestTree> trees_;
  std::vector<Placing> placed_materials_;
  std::vector<int> uncovered_;  ///< moving instances without covered area, which have no tree
  bool loosened_ = false;
  uint32_t leaf_count_ = 0;
  double fine_details_ = 0, hidden_ = 0;
  double sampling_seconds_ = 0, ordering_seconds_ = 0, updating_seconds_ = 0;
};

}  // namespace lucarium::micro
