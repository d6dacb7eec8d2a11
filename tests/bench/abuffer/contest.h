// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/load/load_scene.h"
#include "ray_subject.h"
#include "rounds.h"
#include "structure.h"
#include "traced_batch.h"

namespace lucarium::bench {

inline Scene posed(Scene scene, double seconds, int animation) {
  evaluate(scene, seconds, animation);
  return scene;
}

/// A scene on the device, with the hierarchy.
struct Stage {
  Stage(KernelScheduler& scheduler, Scene of)
      : scene(std::move(of)),
        buffers(scheduler.device(), scene),
        bvh(scheduler.device(), scene, buffers, BvhTraversal::wide) {}
  Scene scene;
  SceneBuffers buffers;
  Bvh bvh;
};

inline SceneChange everything() {
  SceneChange change;
  change.topology = true;
  return change;
}

/// Structures that take turns at something.
class Contest {
 public:
  Contest(Device& device, KernelScheduler& scheduler, int rounds)
      : device_(&device), scheduler_(&scheduler), rounds_(rounds) {}

  void add(const std::string& name, std::function<void()> run, unsigned cpus = 2) {
    contestants_.push_back({.name = name, .run = std::move(run), .cpus = cpus});
  }
  /// A batch of rays through an intersector, on one processor if not said otherwise.
  void add_rays(const std::string& name, const Intersector& intersector, const RaySubject& subject, RayKind kind,
                unsigned cpus = 1) {
    const bool any = kind == RayKind::shadow;
    TracedBatch* batch = batches_
                             .emplace_back(std::make_unique<TracedBatch>(*device_, *scheduler_, intersector,
                                                                         subject.rays(kind), any, subject.starts))
                             .get();
    add(
        name, [batch] { batch->run(); }, cpus);
  }
  void run() { run_rounds(contestants_, rounds_); }

  /// Medians over the rounds: processor seconds, and how many times as long `a` took as `b`.
  double seconds(size_t i) const { return median(contestants_[i].cpu); }
  double ratio(size_t a, size_t b) const { return median_ratio(contestants_[a].cpu, contestants_[b].cpu); }
  /// The shortest elapsed times: what other programs disturb least.
  double fastest(size_t i) const { return *std::min_element(contestants_[i].wall.begin(), contestants_[i].wall.end()); }

 private:
  Device* device_;
  KernelScheduler* scheduler_;
  int rounds_;
  std::vector<std::unique_ptr<TracedBatch>> batches_;
  std::vector<Contestant> contestants_;
};

}  // namespace lucarium::bench
