// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/session/session.h"
#include "lucarium/view/edits/view_technique.h"

namespace lucarium {

/// The sessions of one technique on one scene: one of the whole size, and beside it a coarse one for moments in which a
/// picture matters more than its pixels. Both stay, so that a move of the camera builds nothing again. Where the
/// technique keeps its light from size to size (Capabilities::resizes) there is one, which changes its size.
class ViewSessions {
 public:
  /// `cancel`: asked between passes of an iteration of the whole size; true where its picture is no longer wanted.
  ViewSessions(std::shared_ptr<Device> device, RenderSession::OnPreparing on_preparing, std::function<bool()> cancel);

  /// The scene, which others may share, of sessions that are made from now on; those that are there end.
  void set_scene(std::shared_ptr<SceneOnDevice> scene);

  const std::shared_ptr<SceneOnDevice>& scene() const { return scene_; }
  /// Another technique, other parameters. Throws Error where they are refused; all is then as it was before. It needs
  /// the memory of both for a moment; where that does not suffice the old one goes first, and may be lost.
  void change(const TechniqueType& type, const ViewTechnique& technique, const RenderSettings& settings,
              uint32_t divisor);
  bool empty() const { return !type_; }
  const TechniqueType& type() const { return *type_; }
  const ViewTechnique& technique() const { return technique_; }

  /// The session whose size is the whole one divided by that, brought to the camera. `light_rests`: where the technique
  /// keeps its light from size to size, that does not go on.
  RenderSession& at(uint32_t divisor, bool light_rests = false);
  void set_camera(const SceneCamera& camera);
  /// Moves the scene to a time of its animation, in place, with the session of the whole size alone. Returns false, and
  /// has changed nothing, where there is none or its technique cannot follow.
  bool set_time(double seconds);
  /// From the first sample.
  void restart();
  /// Whether nothing but iterations happened to the session since it was made: a rendering from the start gives the
  /// same picture.
  bool is_fresh(uint32_t divisor) const;
  /// Of iterating, since the first sample of the present picture [s].
  double seconds(uint32_t divisor) const;
  void clear();

 private:
  struct Sized {
    std::unique_ptr<RenderSession> session;
    uint32_t divisor = 0;
    uint64_t camera_number = 0;
    bool fresh = true;
    bool light_rests = false;
    double before = 0;  ///< iterating clock when it was restarted [s]
  };
  Sized make(const TechniqueType& type, const ViewTechnique& technique, const RenderSettings& settings,
             uint32_t divisor) const;
  bool resizes() const { return type_ && type_->info().capabilities.resizes; }
  Sized& slot(uint32_t divisor) { return divisor == 1 || resizes() ? whole_ : coarse_; }
  const Sized& slot(uint32_t divisor) const { return divisor == 1 || resizes() ? whole_ : coarse_; }

  std::shared_ptr<Device> device_;
  std::shared_ptr<SceneOnDevice> scene_;
  RenderSession::OnPreparing on_preparing_;
  std::function<bool()> cancel_;
  const TechniqueType* type_ = nullptr;
  ViewTechnique technique_;
  RenderSettings settings_;
  uint64_t camera_number_ = 0;
  Sized whole_, coarse_;
};

/// The size divided, rounded up.
RenderSettings divided_size(RenderSettings settings, uint32_t divisor);

}  // namespace lucarium
