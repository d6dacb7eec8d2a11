// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/session/session.h"
#include "lucarium/view/edits/view_technique.h"
#include "lucarium/view/sessions/motion.h"

namespace lucarium {

/// Coarse pictures of the scene by path_tracing, where the wanted technique has none soon enough: while it prepares
/// itself for longer than people like to wait, and while the camera moves faster than its pictures come.
class StandIn {
 public:
  static constexpr const char* technique = "path_tracing";

  StandIn(std::shared_ptr<Device> device, RenderSession::OnPreparing on_preparing);

  /// The session that was there ends: also what set_scene() calls.
  void clear();
  void set_scene(std::shared_ptr<SceneOnDevice> scene);
  void follow_camera() { ++camera_number_; }

  /// Whether that technique is expected to prepare itself for long. Throws Error for parameters that it refuses.
  bool is_wanted_for(const TechniqueType& type, const ViewTechnique& wanted, const RenderSettings& settings) const;
  /// The next sample of a picture, as coarse as the wanted rate asks for; `settings` has the whole size. Null where
  /// path_tracing cannot render this; it is not tried again on that scene.
  RenderSession* render(const TechniqueRegistry& registry, const RenderSettings& settings);
  uint32_t divisor() const { return divisor_; }
  /// What the last render() took, with its picture; says nothing of the next where it has made a session.
  void measured(double seconds);

 private:
  void make(const TechniqueRegistry& registry, const RenderSettings& settings, uint32_t divisor);

  std::shared_ptr<Device> device_;
  std::shared_ptr<SceneOnDevice> scene_;
  RenderSession::OnPreparing on_preparing_;
  std::unique_ptr<RenderSession> session_;
  MotionSize motion_;
  uint32_t divisor_ = 0;
  uint64_t camera_number_ = 0, seen_number_ = 0;
  bool has_made_ = false;  ///< the last render() made a session
  bool fails_ = false;
};

}  // namespace lucarium
