// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/dependency_graph.h"

#include <algorithm>
#include <map>
#include <utility>

namespace lucarium {
namespace {

/// What later accesses to a range must wait for.
struct Segment {
  size_t end = 0;
  int writer = -1;
  std::vector<int> readers;  ///< since the writer
};

/// The history of one memory as disjoint segments, by begin.
class MemoryHistory {
 public:
  template <class Report>
  void access(int step, const MemoryAccess& range, const Report& report) {
    if (range.begin >= range.end) return;
    split(range.begin);
    split(range.end);
    fill_gaps(range.begin, range.end);
    for (auto it = segments_.find(range.begin); it != segments_.end() && it->first < range.end; ++it) {
      Segment& segment = it->second;
      if (range.writes) {
        for (const int reader : segment.readers) report(reader, Hazard::write_after_read);
        if (segment.writer >= 0) report(segment.writer, Hazard::write_after_write);
        segment.writer = step;
        segment.readers.clear();
      } else {
        if (segment.writer >= 0) report(segment.writer, Hazard::read_after_write);
        segment.readers.push_back(step);
      }
    }
  }

 private:
  /// Makes `position` a border between segments.
  void split(size_t position) {
    auto it = segments_.upper_bound(position);
    if (it == segments_.begin()) return;
    --it;
    if (it->first == position || it->second.end <= position) return;
    Segment tail = it->second;
    it->second.end = position;
    segments_.emplace(position, std::move(tail));
  }

  void fill_gaps(size_t begin, size_t end) {
    size_t position = begin;
    while (position < end) {
      auto it = segments_.lower_bound(position);
      const size_t next = it == segments_.end() ? end : std::min(it->first, end);
      if (position < next) {
        segments_.emplace(position, Segment{next, -1, {}});
        position = next;
      } else {
        position = it->second.end;
      }
    }
  }

  std::map<size_t, Segment> segments_;
};

}  // namespace

std::vector<Dependency> derive_dependencies(const std::vector<std::vector<MemoryAccess>>& steps) {
  std::map<int, MemoryHistory> histories;
  std::vector<Dependency> dependencies;
  for (int step = 0; step < static_cast<int>(steps.size()); ++step) {
    std::map<int, Dependency> found;  // by predecessor
    for (const MemoryAccess& range : steps[static_cast<size_t>(step)]) {
      histories[range.memory].access(step, range, [&](int from, Hazard hazard) {
        if (from == step) return;  // the step's own earlier argument
        const auto [it, fresh] = found.try_emplace(from, Dependency{from, step, range.memory, hazard});
        if (!fresh && hazard == Hazard::read_after_write) it->second = {from, step, range.memory, hazard};
      });
    }
    for (const auto& [from, dependency] : found) dependencies.push_back(dependency);
  }
  return dependencies;
}

DependencyGraph::DependencyGraph(int step_count, const std::vector<Dependency>& dependencies)
    : words_((static_cast<size_t>(step_count) + 63) / 64),
      predecessors_(static_cast<size_t>(step_count)),
      ancestors_(static_cast<size_t>(step_count) * words_, 0) {
  std::vector<std::vector<Dependency>> incoming(static_cast<size_t>(step_count));
  for (const Dependency& dependency : dependencies) incoming[static_cast<size_t>(dependency.to)].push_back(dependency);
  for (size_t step = 0; step < incoming.size(); ++step) {
    // Latest predecessor first: an earlier one that it already waits for is implied.
    std::sort(incoming[step].begin(), incoming[step].end(),
              [](const Dependency& a, const Dependency& b) { return a.from > b.from; });
    uint64_t* mine = &ancestors_[step * words_];
    for (const Dependency& dependency : incoming[step]) {
      const size_t from = static_cast<size_t>(dependency.from);
      if (mine[from / 64] >> (from % 64) & 1) continue;
      for (size_t word = 0; word < words_; ++word) mine[word] |= ancestors_[from * words_ + word];
      mine[from / 64] |= uint64_t{1} << (from % 64);
      predecessors_[step].push_back(dependency.from);
      reduced_.push_back(dependency);
    }
    std::reverse(predecessors_[step].begin(), predecessors_[step].end());
  }
  std::sort(reduced_.begin(), reduced_.end(),
            [](const Dependency& a, const Dependency& b) { return std::pair(a.from, a.to) < std::pair(b.from, b.to); });
}

bool DependencyGraph::depends(int later, int earlier) const {
  const size_t bit = static_cast<size_t>(earlier);
  return ancestors_[static_cast<size_t>(later) * words_ + bit / 64] >> (bit % 64) & 1;
}

}  // namespace lucarium
