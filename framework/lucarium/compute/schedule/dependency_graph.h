// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lucarium {

/// A byte range of physical memory that one step touches. A step that reads and writes a range lists it as a write.
struct MemoryAccess {
  int memory = 0;
  size_t begin = 0, end = 0;
  bool writes = false;
};

enum class Hazard { read_after_write, write_after_read, write_after_write };

/// Step `to` must not start before step `from` has ended, because of `memory`.
struct Dependency {
  int from = 0, to = 0;
  int memory = 0;
  Hazard hazard = Hazard::read_after_write;
};

/// Every hazard between steps in program order, at most one per pair of steps (true dependencies preferred). Ranges
/// count, not whole memories: two steps that touch disjoint parts are independent.
std::vector<Dependency> derive_dependencies(const std::vector<std::vector<MemoryAccess>>& steps);

/// The order that the dependencies impose, without those that follow from others (transitive reduction).
class DependencyGraph {
 public:
  DependencyGraph() = default;
  DependencyGraph(int step_count, const std::vector<Dependency>& dependencies);

  const std::vector<int>& predecessors(int step) const { return predecessors_[static_cast<size_t>(step)]; }
  const std::vector<Dependency>& dependencies() const { return reduced_; }
  int step_count() const { return static_cast<int>(predecessors_.size()); }
  /// Whether `later` must wait for `earlier`, directly or not.
  bool depends(int later, int earlier) const;
  bool independent(int a, int b) const { return a != b && !depends(a, b) && !depends(b, a); }

 private:
  size_t words_ = 0;
  std::vector<std::vector<int>> predecessors_;
  std::vector<Dependency> reduced_;
  std::vector<uint64_t> ancestors_;  ///< one bit set of step_count bits per step
};

}  // namespace lucarium
