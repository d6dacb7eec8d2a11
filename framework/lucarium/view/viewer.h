// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "lucarium/base/stopwatch.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/view/hub.h"
#include "lucarium/view/pixel_inspector.h"
#include "lucarium/view/side_flip.h"
#include "lucarium/view/view_side.h"
#include "lucarium/view/view_truth.h"

namespace lucarium {

struct ViewerOptions {
  RenderSettings settings;  ///< the camera is the scene's first
  /// At least one; the first one runs.
  std::vector<ViewTechnique> techniques;
  RenderBudget budget;  ///< of a picture; 0: it goes on
  RepeatCommands commands;
  EditedScene edited;
};

/// Renders what the hub's request says, on one thread, and leaves pictures and states there. Pages hear what throws;
/// the viewer lives on.
class Viewer {
 public:
  Viewer(std::shared_ptr<Device> device, Scene scene, const TechniqueRegistry& registry, ViewerOptions options,
         ViewHub& hub);
  /// Until stop(), or an interrupt.
  void run();
  void stop() { stopped_ = true; }

 private:
  void step();
  void follow(const ViewRequest& request);
  void follow_camera(const ViewRequest& request);
  void follow_side(uint32_t index, const ViewRequest& before);
  void follow_scene();
  void take_back_edits();
  void end_truth();
  void replace_scene(Scene scene, bool moved);
  void take_scene(const Scene& scene);
  void take_cameras(const Scene& scene);
  bool move_scene(double seconds);
  uint32_t sides() const { return around_.request.beside ? view_sides : 1; }
  ViewSide* next_side();
  bool is_truth_next(const ViewSide* side) const;
  void attempt(ViewSide& side, const std::function<void()>& call);
  bool should_stop() const;
  void send_flip();
  void send_files();
  void report(bool now);
  bool is_quiet() const;
  nlohmann::ordered_json status();

  std::vector<SceneCamera> cameras_;
  Bounds bounds_;
  const TechniqueRegistry& registry_;
  std::vector<ViewTechnique> named_;
  ViewHub& hub_;
  std::atomic<bool> stopped_{false};
  uint64_t changes_ = 0;  ///< of the hub, when the request was read
  ViewSurroundings around_;
  std::array<std::unique_ptr<ViewSide>, view_sides> sides_;
  SideFlip flip_;
  EditedScene edited_;
  std::shared_ptr<SceneOnDevice> scene_;
  std::string scene_refusal_;
  ViewTruth truth_;
  PixelInspector inspector_;

  Stopwatch since_report_;
  bool reported_quiet_ = false;
  uint64_t reported_changes_ = 0;
};

}  // namespace lucarium
