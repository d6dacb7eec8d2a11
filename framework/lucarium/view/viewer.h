// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/view/hub.h"
#include "lucarium/view/motion.h"
#include "lucarium/view/view_sessions.h"

namespace lucarium {

/// What a picture on the page was rendered with: what it takes to render it again.
struct ViewedPicture {
  ViewTechnique technique;
  std::optional<CameraKey> camera;  ///< empty: a camera of the scene
  uint32_t scene_camera = 0;
  uint64_t iterations = 0;
};

struct ViewerOptions {
  RenderSettings settings;  ///< the camera is the scene's first
  /// At least one; the first one runs.
  std::vector<ViewTechnique> techniques;
  RenderBudget budget;  ///< of a picture; 0: it goes on
  /// The command lines that render a picture again, by what they are for.
  std::function<std::vector<std::pair<std::string, std::string>>(const ViewedPicture&)> commands;
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
  enum class Stage { preparing, rendering, done, paused, waiting, failed };
  void step();
  void follow(const ViewRequest& request);
  void follow_camera(const ViewRequest& request);
  void follow_technique(const ViewRequest& request);
  void take(const ViewTechnique& technique);
  void refuse(const ViewTechnique& technique, const Error& error);
  bool should_stop() const;
  bool has_work() const;
  void work();
  uint32_t choose_divisor() const;
  bool reached_budget(const RenderSession& session) const;
  bool is_picture_due(const RenderSession& session) const;
  void send_picture(RenderSession& session);
  void send_files();
  void report(bool now);
  nlohmann::ordered_json status() const;
  RenderSettings settings() const;
  double whole_pixels() const;
  void fail(const std::string& why);
  void begin_picture();
  static const char* stage_name(Stage stage);

  std::shared_ptr<Device> device_;
  std::vector<SceneCamera> cameras_;
  Bounds bounds_;
  float exposure_;
  const TechniqueRegistry& registry_;
  ViewerOptions options_;
  ViewHub& hub_;
  std::string welcome_;
  ViewSessions sessions_;
  std::atomic<bool> stopped_{false};

  ViewRequest request_;   ///< that is being followed
  uint64_t changes_ = 0;  ///< of the hub, when the request was read
  SceneCamera camera_;
  RenderSession* session_ = nullptr;  ///< that worked last
  uint32_t divisor_ = 0;              ///< of that
  MotionSize motion_;
  bool done_ = false, failed_ = false;

  Stopwatch since_picture_began_, since_sent_, since_report_;
  double serving_seconds_ = 0;  ///< spent on pictures of this camera and technique
  double picture_cost_ = 0;     ///< of the last one [s]
  uint64_t picture_number_ = 0, sent_iterations_ = 0;
  uint32_t sent_divisor_ = 0;  ///< 0: nothing of the present picture was sent
  std::vector<std::string> layers_;

  std::string stage_text_, refusal_, failure_;
  double stage_fraction_ = -1;
  Stage stage_ = Stage::preparing;
  Stage reported_ = Stage::failed;
  uint64_t reported_changes_ = 0;
};

}  // namespace lucarium
