// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/hub.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium {

using Kind = ViewMessage::Kind;

namespace {

constexpr double messages_per_second = 200, messages_at_once = 400;
// What waits for a page that takes nothing: messages, and bytes of files.
constexpr size_t longest_queue = 64, largest_queue = size_t{256} << 20;
constexpr int pictures_on_the_way = 2;  // one is drawn while the next one travels
constexpr size_t max_saves = 4;

std::string dump(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

ViewHub::Outgoing ViewHub::text(std::string data) {
  return {false, std::make_shared<const std::string>(std::move(data))};
}

void ViewHub::on_news(std::function<void()> call) {
  const std::lock_guard lock(mutex_);
  on_news_ = std::move(call);
}

/// With the mutex held: `on_news_` only wakes the serving thread.
void ViewHub::news() {
  if (on_news_) on_news_();
}

std::optional<uint64_t> ViewHub::join() {
  const std::lock_guard lock(mutex_);
  if (pages_.size() >= max_pages) return std::nullopt;
  const uint64_t id = ++last_page_;
  Page& page = pages_[id];
  page.allowance = messages_at_once;
  page.counted = Clock::now();
  if (welcome_.data) replace(page, page.welcome, welcome_);
  if (scene_.data) replace(page, page.scene, scene_);
  if (controls_ == 0) controls_ = id;
  tell_control();
  has_asked_ = true;
  asked_.notify_all();
  return id;
}

void ViewHub::leave(uint64_t page) {
  const std::lock_guard lock(mutex_);
  pages_.erase(page);
  if (controls_ == page) controls_ = pages_.empty() ? 0 : pages_.begin()->first;
  if (pages_.empty()) empty_since_ = Clock::now();
  std::erase_if(saves_, [page](const ViewSave& save) { return save.page == page; });
  tell_control();
}

void ViewHub::tell_control() {
  for (auto& [id, page] : pages_)
    replace(page, page.control, text(dump({{"control", id == controls_}, {"pages", pages_.size()}})));
  news();
}

void ViewHub::replace(Page& page, Outgoing& last, Outgoing now) {
  std::erase_if(page.queue, [&](const Outgoing& waiting) { return last.data && waiting.data == last.data; });
  page.queue.push_back(now);
  last = std::move(now);
}

bool ViewHub::may_send(Page& page) const {
  const Clock::time_point now = Clock::now();
  page.allowance += messages_per_second * std::chrono::duration<double>(now - page.counted).count();
  page.allowance = std::min(page.allowance, messages_at_once) - 1;
  page.counted = now;
  if (page.allowance >= 0) return true;
  page.allowance = 0;
  return false;
}

void ViewHub::answer(Page& page, const std::optional<int64_t>& id, const std::string& error) {
  if (!id && error.empty()) return;
  if (page.queue.size() >= longest_queue) return;
  nlohmann::ordered_json answer = nlohmann::ordered_json::object();
  answer["answer"] = id ? nlohmann::ordered_json(*id) : nlohmann::ordered_json(nullptr);
  if (!error.empty()) answer["error"] = error;
  page.queue.push_back(text(dump(answer)));
  news();
}

void ViewHub::receive(uint64_t id, std::string_view text) {
  const std::lock_guard lock(mutex_);
  const auto found = pages_.find(id);
  if (found == pages_.end()) return;
  Page& page = found->second;
  if (!may_send(page)) return answer(page, std::nullopt, "too many messages");
  try {
    apply(id, page, parse_view_message(text));
  } catch (const Error& error) {
    answer(page, view_message_id(text), error.what());
  }
}

void ViewHub::refuse(uint64_t id, const std::string& why) {
  const std::lock_guard lock(mutex_);
  const auto found = pages_.find(id);
  if (found != pages_.end()) answer(found->second, std::nullopt, why);
}

void ViewHub::apply(uint64_t id, Page& page, const ViewMessage& message) {
  if (message.kind == Kind::shown) {
    if (message.picture > page.sent) throw_error(ErrorClass::usage, "that picture was not sent");
    page.shown = std::max(page.shown, message.picture);
    page.on_the_way = page.shown == page.sent ? 0 : std::min(page.on_the_way, pictures_on_the_way - 1);
    news();
    return answer(page, message.id, "");
  }
  if (message.kind == Kind::control) {
    controls_ = id;
    tell_control();
    return answer(page, message.id, "");
  }
  if (message.kind != Kind::save && id != controls_) throw_error(ErrorClass::usage, "another page controls the viewer");
  if (message.kind == Kind::save) {
    if (saves_.size() >= max_saves) throw_error(ErrorClass::usage, "files are being made; ask again later");
    saves_.push_back({id, message.name, message.exposure});
  } else {
    change_request(message);
  }
  has_asked_ = true;
  asked_.notify_all();
  answer(page, message.id, "");
}

void ViewHub::change_request(const ViewMessage& message) {
  switch (message.kind) {
    case Kind::camera:
      request_.camera = message.camera;
      request_.camera_time = Clock::now();
      ++request_.camera_number;
      break;
    case Kind::scene_camera:
      request_.camera.reset();
      request_.scene_camera = message.index;
      request_.camera_time = {};
      ++request_.camera_number;
      break;
    case Kind::technique:
      request_.sides.at(message.index) = {message.name, message.parameters,
                                          request_.sides.at(message.index).number + 1};
      break;
    case Kind::beside:
      request_.beside = message.name != "none";
      request_.flip = message.name == "flip";
      break;
    case Kind::layer:
      request_.layer = message.name;
      ++request_.layer_number;
      break;
    case Kind::inspect:
      request_.inspect_x = message.x;
      request_.inspect_y = message.y;
      ++request_.inspect_number;
      break;
    case Kind::reference: request_.reference = message.on; break;
    case Kind::scene: {
      const std::optional<double> seconds = request_.edits.seconds;
      request_.edits = message.edits;
      request_.edits.seconds = seconds;
      ++request_.scene_number;
      break;
    }
    case Kind::time:
      request_.edits.seconds = message.edits.seconds;
      request_.scene_time = Clock::now();
      ++request_.scene_number;
      break;
    case Kind::pause: request_.paused = message.on; break;
    case Kind::restart: ++request_.restart_number; break;
    case Kind::save:
    case Kind::shown:
    case Kind::control: break;
  }
  if (message.kind == Kind::camera || message.kind == Kind::scene_camera || message.kind == Kind::technique ||
      message.kind == Kind::scene || message.kind == Kind::time)
    ++changes_;
}

/// The oldest one that the page has not got: it stays in step with all slots.
const ViewHub::Picture* ViewHub::next_picture(Page& page) {
  const Picture* next = nullptr;
  size_t chosen = 0;
  for (size_t slot = 0; slot < slots; ++slot) {
    const Picture& picture = pictures_[slot];
    if (picture.number <= page.sent_of[slot] || (next && next->number < picture.number)) continue;
    next = &picture;
    chosen = slot;
  }
  if (!next) return nullptr;
  page.sent_of[chosen] = page.sent = next->number;
  return next;
}

std::optional<ViewHub::Outgoing> ViewHub::next(uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = pages_.find(id);
  if (found == pages_.end()) return std::nullopt;
  Page& page = found->second;
  if (!page.queue.empty()) {
    const Outgoing first = page.queue.front();
    page.queue.pop_front();
    return first;
  }
  if (page.status < status_number_) {
    page.status = status_number_;
    return status_;
  }
  if (page.on_the_way >= pictures_on_the_way) return std::nullopt;
  const Picture* const picture = next_picture(page);
  if (!picture) return std::nullopt;
  ++page.on_the_way;
  return picture->data;
}

void ViewHub::set_welcome(std::string data) {
  const std::lock_guard lock(mutex_);
  welcome_ = text(std::move(data));
  for (auto& [id, page] : pages_) replace(page, page.welcome, welcome_);
  news();
}

void ViewHub::set_scene(std::string data) {
  const std::lock_guard lock(mutex_);
  scene_ = text(std::move(data));
  for (auto& [id, page] : pages_) replace(page, page.scene, scene_);
  news();
}

void ViewHub::set_notice(const std::string& why) {
  const std::lock_guard lock(mutex_);
  for (auto& [id, page] : pages_)
    if (page.queue.size() < longest_queue) page.queue.push_back(text(dump({{"error", why}})));
  news();
}

void ViewHub::set_status(std::string data) {
  const std::lock_guard lock(mutex_);
  status_ = text(std::move(data));
  ++status_number_;
  news();
}

void ViewHub::set_picture(size_t slot, uint64_t number, std::string data) {
  const std::lock_guard lock(mutex_);
  pictures_.at(slot) = {{true, std::make_shared<const std::string>(std::move(data))}, number};
  news();
}

void ViewHub::send_file(uint64_t id, std::string data) {
  const std::lock_guard lock(mutex_);
  const auto found = pages_.find(id);
  if (found == pages_.end()) return;
  Page& page = found->second;
  size_t waiting = data.size();
  for (const Outgoing& other : page.queue) waiting += other.data->size();
  if (waiting > largest_queue && !page.queue.empty())
    return answer(page, std::nullopt, "earlier files wait to be taken; ask again later");
  page.queue.push_back({true, std::make_shared<const std::string>(std::move(data))});
  news();
}

void ViewHub::send_error(uint64_t id, const std::string& why) { refuse(id, why); }

ViewRequest ViewHub::request() const {
  const std::lock_guard lock(mutex_);
  return request_;
}

void ViewHub::set_request(const std::function<void(ViewRequest&)>& edit) {
  const std::lock_guard lock(mutex_);
  edit(request_);
}

std::vector<ViewSave> ViewHub::take_saves() {
  const std::lock_guard lock(mutex_);
  return std::exchange(saves_, {});
}

bool ViewHub::wants_picture() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(pages_.begin(), pages_.end(),
                     [](const auto& entry) { return entry.second.on_the_way < pictures_on_the_way; });
}

size_t ViewHub::pages() const {
  const std::lock_guard lock(mutex_);
  return pages_.size();
}

double ViewHub::seconds_without_pages() const {
  const std::lock_guard lock(mutex_);
  if (!pages_.empty()) return 0;
  return std::chrono::duration<double>(Clock::now() - empty_since_).count();
}

void ViewHub::wait(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  asked_.wait_for(lock, time, [this] { return has_asked_; });
  has_asked_ = false;
}

}  // namespace lucarium
