// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/view/hub.h"
#include "lucarium/view/sessions/motion.h"
#include "lucarium/view/sessions/stand_in.h"
#include "lucarium/view/sessions/view_sessions.h"

namespace lucarium {

/// What a picture on the page was rendered with: what it takes to render it again.
struct ViewedPicture {
  ViewTechnique technique;
  std::optional<CameraKey> camera;  ///< empty: a camera of the scene
  uint32_t scene_camera = 0;
  uint64_t iterations = 0;
  SceneEdits edits;
  std::vector<ViewTechnique> others;  ///< that are seen beside it
};

/// What makes a picture again: a command line, or a file where `file` has a name for it.
struct RepeatText {
  std::string name, text, file;
};

using RepeatCommands = std::function<std::vector<RepeatText>(const ViewedPicture&)>;

/// What all sides of a viewer have in common.
struct ViewSurroundings {
  std::shared_ptr<Device> device;
  RenderSettings settings;  ///< the camera is the present one
  RenderBudget budget;      ///< of a picture; 0: it goes on
  RepeatCommands commands;
  float exposure = 0;           ///< [stops] NaN: automatic
  SceneEdits edits;             ///< that the scene has; those asked for may have been refused
  ViewRequest request;          ///< that is being followed
  uint64_t picture_number = 0;  ///< of the last one sent, of any side
};

/// One technique at work: brings its sessions to what is wanted, decides how coarse, and which pictures to send. Where
/// its own come too late, another's stand in.
class ViewSide {
 public:
  enum class Stage { preparing, rendering, done, paused, waiting, failed };

  /// `preparing`: called while a session is made, when its stage is another. `unwanted`: asked between passes.
  ViewSide(ViewSurroundings& around, ViewHub& hub, uint32_t index, std::function<void()> preparing,
           std::function<bool()> unwanted);

  /// `moved`: to another time.
  void set_scene(std::shared_ptr<SceneOnDevice> scene, bool moved);
  void follow_camera();
  /// Builds its session. Its first picture is coarse unless the whole one comes as quickly, or light is kept from size
  /// to size. What is refused leaves what ran before.
  void take(const TechniqueRegistry& registry, const ViewTechnique& technique);
  void restart();
  void show_again() { sent_iterations_ = UINT64_MAX, serving_seconds_ = 0; }
  void clear();
  /// Its technique has thrown.
  void fail(const std::string& why);

  bool has_work() const;
  /// An iteration; then a picture, where one is due.
  void work();
  /// Without work: the last picture, where it was not sent. Returns whether one was.
  bool rest();
  /// Seconds of work since the picture began.
  double spent() const { return spent_; }
  /// Another side has worked so long already: this one does not catch up.
  void catch_up(double spent) { spent_ = std::max(spent_, spent); }

  bool empty() const { return sessions_.empty(); }
  const ViewTechnique& technique() const { return sessions_.technique(); }
  /// Of iterating, since the first sample of the present picture.
  double seconds() const { return sessions_.seconds(divisor_); }
  /// The whole picture; null where there is none yet.
  RenderSession* whole();
  /// What was sent last; null: nothing of the present picture.
  const Film* film() const { return sent_divisor_ == 0 ? nullptr : film_.get(); }
  uint32_t film_divisor() const { return sent_divisor_; }
  uint64_t film_number() const { return film_number_; }  ///< of its picture
  Stage stage() const { return stage_; }
  /// Of the animation, in place, where its session is the only one of the scene and can follow; false: it cannot.
  bool set_time(double seconds);
  /// `others`: what is seen beside it.
  nlohmann::ordered_json status(const std::vector<ViewTechnique>& others);
  void set_preparing(double fraction, const std::string& stage);

 private:
  void refuse(const ViewTechnique& technique, const Error& error);
  uint32_t choose_divisor() const;
  bool reached_budget(const RenderSession& session) const;
  bool is_picture_due(const RenderSession& session) const;
  bool stands_in();
  /// The next sample of another technique's picture, which is sent where it is wanted. False where there is none.
  bool show_stand_in(bool wanted);
  void iterate();
  bool camera_moves() const;
  bool time_moves() const;
  bool moves() const { return camera_moves() || time_moves(); }
  bool light_rests() const;
  void send_picture(RenderSession& session);
  void send(RenderSession& session, const Film& film, uint32_t divisor, double seconds, const ViewTechnique& by);
  double whole_pixels() const;
  void begin_picture();

  ViewSurroundings& around_;
  ViewHub& hub_;
  uint32_t index_;
  std::function<void()> preparing_;
  ViewSessions sessions_;
  RenderSession* session_ = nullptr;  ///< that worked last
  uint32_t divisor_ = 0;              ///< of that
  MotionSize motion_;
  double unseen_seconds_ = 0;  ///< of iterations since the last one with a picture, or since that was too long
  bool scene_moved_ = false;   ///< since then no picture had a whole sample
  const TechniqueRegistry* registry_ = nullptr;
  StandIn stand_in_;
  bool standing_in_ = false;  ///< the last work() showed that
  Stopwatch since_found_too_slow_;
  bool done_ = false, failed_ = false;
  double spent_ = 0;

  Stopwatch since_picture_began_, since_sent_;
  double serving_seconds_ = 0;  ///< spent on pictures of this camera and technique
  double picture_cost_ = 0;     ///< of the last one [s]
  uint64_t sent_iterations_ = 0;
  uint32_t sent_divisor_ = 0;  ///< 0: nothing of the present picture was sent
  std::unique_ptr<Film> film_;
  uint64_t film_number_ = 0;
  std::vector<std::string> layers_;

  std::string stage_text_, refusal_, failure_;
  std::string meanwhile_;  ///< the technique of the picture that is seen until this one's next
  double stage_fraction_ = -1;
  Stage stage_ = Stage::waiting;
};

}  // namespace lucarium
