// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lucarium/scene/camera_path.h"
#include "lucarium/view/protocol.h"

namespace lucarium {

/// What the page that controls wants: the state that the rendering thread runs after. A number that has grown says
/// that a part was asked for again.
struct ViewRequest {
  struct Side {
    std::string technique;
    std::vector<std::pair<std::string, std::string>> parameters;
    uint64_t number = 0;
  };
  std::array<Side, view_sides> sides;
  bool beside = false;  ///< both sides render
  bool flip = false;    ///< FLIP of the two is wanted
  uint32_t scene_camera = 0;
  std::optional<CameraKey> camera;  ///< instead of the scene's
  uint64_t camera_number = 0;
  /// Of the last move of the camera, and of the last change of the animation's time.
  std::chrono::steady_clock::time_point camera_time{}, scene_time{};
  std::string layer;
  uint64_t layer_number = 0;
  uint64_t restart_number = 0;
  bool paused = false;
  bool reference = false;
  SceneEdits edits;
  uint64_t scene_number = 0;
  uint32_t inspect_x = 0, inspect_y = 0;
  uint64_t inspect_number = 0;  ///< 0: nothing is
};

/// A file that a page asked for.
struct ViewSave {
  uint64_t page = 0;
  std::string kind;    ///< exr, png
  float exposure = 0;  ///< [stops]
};

/// Between the thread that serves pages and the one that renders. Pages leave what they want, the renderer leaves what
/// there is to see; neither waits for the other, and a page that does not take its pictures misses some. Thread-safe.
class ViewHub {
 public:
  struct Outgoing {
    bool binary = false;
    std::shared_ptr<const std::string> data;
  };
  /// Pages at once; further ones are refused.
  static constexpr size_t max_pages = 16;
  /// Pictures that are kept side by side.
  static constexpr size_t slots = view_sides + 1;

  // ---- The serving thread.

  /// Called from any thread when there may be something to send.
  void on_news(std::function<void()> call);
  /// A number for a new page; empty where there are too many. The first page controls.
  std::optional<uint64_t> join();
  void leave(uint64_t page);
  /// A message of the page. What it says wrong, and more messages a second than people and mice make, are answered with
  /// an error.
  void receive(uint64_t page, std::string_view text);
  /// Instead of a message that was too long or no text.
  void refuse(uint64_t page, const std::string& why);
  /// What the page gets next: answers, the state, then the last picture, when it has shown those before.
  std::optional<Outgoing> next(uint64_t page);

  // ---- The rendering thread.

  /// What every page gets first.
  void set_welcome(std::string text);
  /// What every page gets now, and others after the welcome.
  void set_scene(std::string text);
  void set_status(std::string text);
  /// A message for people on all pages that are there.
  void set_notice(const std::string& why);
  /// The picture of that number (from 1, ascending), for all pages, instead of the last one in its slot: one for each
  /// side, one for what is between them.
  void set_picture(size_t slot, uint64_t number, std::string data);
  /// What a page asked for with "save".
  void send_file(uint64_t page, std::string data);
  void send_error(uint64_t page, const std::string& why);

  ViewRequest request() const;
  /// Begins with this one, and changes it where a request could not be met.
  void set_request(const std::function<void(ViewRequest&)>& edit);
  std::vector<ViewSave> take_saves();
  /// Whether a page has room for another picture.
  bool wants_picture() const;
  /// Grows whenever what is being rendered is no longer wanted: another camera, another technique. Cheap to ask.
  uint64_t changes() const { return changes_; }
  size_t pages() const;
  /// Seconds since there was a page; 0 while there is one.
  double seconds_without_pages() const;
  /// Until a page asks for something, or joins, or the time is over.
  void wait(std::chrono::milliseconds time);

 private:
  using Clock = std::chrono::steady_clock;
  struct Picture {
    Outgoing data;
    uint64_t number = 0;
  };
  struct Page {
    std::deque<Outgoing> queue;             ///< answers and files, and the three below
    Outgoing welcome, scene, control;       ///< the last ones that were put there
    uint64_t status = 0;                    ///< number of the last one sent
    std::array<uint64_t, slots> sent_of{};  ///< the last picture of each slot
    uint64_t sent = 0, shown = 0;           ///< pictures
    int on_the_way = 0;                     ///< pictures that were sent and not yet shown
    double allowance = 0;                   ///< messages that it may send now
    Clock::time_point counted{};
  };
  static Outgoing text(std::string data);
  /// Queues what makes the `last` of its kind void, which is dropped where it still waits.
  static void replace(Page& page, Outgoing& last, Outgoing now);
  void answer(Page& page, const std::optional<int64_t>& id, const std::string& error);
  bool may_send(Page& page) const;
  void apply(uint64_t id, Page& page, const ViewMessage& message);
  void change_request(const ViewMessage& message);
  const Picture* next_picture(Page& page);
  void tell_control();
  void news();

  mutable std::mutex mutex_;
  std::condition_variable asked_;
  bool has_asked_ = false;
  std::function<void()> on_news_;
  std::map<uint64_t, Page> pages_;
  uint64_t last_page_ = 0, controls_ = 0;
  Clock::time_point empty_since_ = Clock::now();
  ViewRequest request_;
  std::vector<ViewSave> saves_;
  Outgoing welcome_, scene_, status_;
  std::array<Picture, slots> pictures_;
  uint64_t status_number_ = 0;
  std::atomic<uint64_t> changes_{0};
};

}  // namespace lucarium
