// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/view_side.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/view/film_picture.h"
#include "lucarium/view/status.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr double settled_seconds = 0.2;       // after a move, before the whole size is rendered
constexpr double quick_seconds = 0.3;         // a first picture that takes longer comes coarse before
constexpr double serving_share = 0.03;        // of the time, for pictures
constexpr double serving_at_first = 0.25;     // [s] for a new picture, beside that share
constexpr double shortest_interval = 0.04;    // [s] between pictures while nothing moves
constexpr double patience_without_page = 60;  // [s] then rendering waits
constexpr double longest_wait = 0.5;          // [s] between pictures while time moves, for all of their light
constexpr double tried_again = 30;            // [s] after another stood in for a technique that was too slow
constexpr std::chrono::milliseconds nap{50};

double seconds_since(std::chrono::steady_clock::time_point time) {
  if (time == std::chrono::steady_clock::time_point{}) return INFINITY;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - time).count();
}

const char* stage_name(ViewSide::Stage stage) {
  using Stage = ViewSide::Stage;
  switch (stage) {
    case Stage::preparing: return "preparing";
    case Stage::rendering: return "rendering";
    case Stage::done: return "done";
    case Stage::paused: return "paused";
    case Stage::waiting: return "waiting";
    case Stage::failed: return "failed";
  }
  return "";
}

}  // namespace

ViewSide::ViewSide(ViewSurroundings& around, ViewHub& hub, uint32_t index, std::function<void()> preparing,
                   std::function<bool()> unwanted)
    : around_(around),
      hub_(hub),
      index_(index),
      preparing_(std::move(preparing)),
      sessions_(
          around.device, [this](double fraction, const std::string& stage) { set_preparing(fraction, stage); },
          std::move(unwanted)),
      stand_in_(around.device, [this](double fraction, const std::string& stage) { set_preparing(fraction, stage); }) {}

void ViewSide::set_preparing(double fraction, const std::string& stage) {
  stage_ = Stage::preparing;
  stage_text_ = stage;
  stage_fraction_ = fraction;
  preparing_();
}

void ViewSide::set_scene(std::shared_ptr<SceneOnDevice> scene, bool moved) {
  scene_moved_ = moved && !sessions_.empty();
  session_ = nullptr;
  stand_in_.set_scene(scene);
  sessions_.set_scene(std::move(scene));
}

void ViewSide::follow_camera() {
  sessions_.set_camera(around_.settings.camera);
  stand_in_.follow_camera();
  // Who drags after a picture of the new time was seen wants many: the light that is there rests.
  if (camera_moves() && !time_moves() && sent_divisor_ != 0) scene_moved_ = false;
  const double unseen = camera_moves() ? unseen_seconds_ : 0;
  begin_picture();
  unseen_seconds_ = unseen;
}

void ViewSide::take(const TechniqueRegistry& registry, const ViewTechnique& technique) {
  failure_.clear();
  registry_ = &registry;
  try {
    const TechniqueType& type = registry.find(technique.name);
    const Capabilities& can = type.info().capabilities;
    if (sessions_.empty() || sessions_.technique().name != technique.name) {
      motion_.forget();
      scene_moved_ = time_moves();
    } else {
      motion_.forget_slow();
    }
    set_preparing(-1, "preparing");
    if (sessions_.empty() && stand_in_.is_wanted_for(type, technique, around_.settings))
      show_stand_in(true);  // also for pages that come
    stand_in_.clear();      // the memory is for what is wanted
    standing_in_ = false;
    const uint32_t divisor = can.view_independent || can.resizes ? 1 : motion_.divisor(whole_pixels(), 0);
    sessions_.change(type, technique, around_.settings, divisor);
    session_ = nullptr;
    failed_ = false;
    refusal_.clear();
    begin_picture();
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::interrupted) throw;
    refuse(technique, error);
  }
}

/// While the camera moves faster than the technique's own pictures come, at the coarsest size. Now and then it is tried
/// again: the machine may have been busy.
bool ViewSide::stands_in() {
  if (!moves() || sessions_.technique().name == StandIn::technique) return false;
  const bool slow = motion_.is_too_slow();
  if (!slow) since_found_too_slow_.restart();
  if (since_found_too_slow_.seconds() > tried_again) motion_.doubt();
  return slow;
}

bool ViewSide::show_stand_in(bool wanted) {
  const Stopwatch watch;
  RenderSession* const session = stand_in_.render(*registry_, around_.settings);
  if (!session) return false;
  standing_in_ = true;
  // One for each camera, and then as it gets better.
  const bool is_new = session->iterations() == 1 || since_sent_.seconds() >= shortest_interval;
  if (wanted && is_new && session->last().samples > 0) {
    since_sent_.restart();
    meanwhile_ = StandIn::technique;
    Film film(session->settings().width, session->settings().height);
    session->technique().resolve(film);
    send(*session, film, stand_in_.divisor(), session->clocks().iterate, {StandIn::technique, {}});
  }
  stand_in_.measured(watch.seconds());
  return true;
}

/// What ran before goes on, where there is anything.
void ViewSide::refuse(const ViewTechnique& technique, const Error& error) {
  refusal_ = error.what();
  if (!error.details().empty()) refusal_ += "\n" + error.details();
  log_info("{} was refused: {}", technique.name, error.what());
  if (sessions_.empty()) {
    failed_ = true;
    session_ = nullptr;
    meanwhile_.clear();
  }
}

void ViewSide::restart() {
  failed_ = false;
  sessions_.restart();
  begin_picture();
}

void ViewSide::clear() {
  session_ = nullptr;
  sessions_.clear();
  stand_in_.clear();
  film_.reset();
  meanwhile_.clear();
  sent_divisor_ = 0;
  scene_moved_ = false;
  stage_ = Stage::waiting;
}

void ViewSide::fail(const std::string& why) {
  failed_ = true;
  failure_ = why;
  clear();
  stage_ = Stage::failed;
}

double ViewSide::whole_pixels() const { return double{1} * around_.settings.width * around_.settings.height; }

void ViewSide::begin_picture() {
  done_ = standing_in_ = false;
  sent_divisor_ = 0;
  serving_seconds_ = 0;
  unseen_seconds_ = 0;
  spent_ = 0;
  since_picture_began_.restart();
}

bool ViewSide::has_work() const {
  if (failed_ || sessions_.empty() || done_) return false;
  if (hub_.seconds_without_pages() > patience_without_page && sent_divisor_ == 1) return false;
  return !around_.request.paused || sent_divisor_ != 1;
}

bool ViewSide::camera_moves() const { return seconds_since(around_.request.camera_time) < settled_seconds; }
bool ViewSide::time_moves() const { return seconds_since(around_.request.scene_time) < settled_seconds; }

/// While the camera alone moves: another time takes the light away, which then has to come back.
bool ViewSide::light_rests() const {
  return camera_moves() && !time_moves() && !scene_moved_ && sessions_.type().info().capabilities.resizes;
}

uint32_t ViewSide::choose_divisor() const {
  const Capabilities& can = sessions_.type().info().capabilities;
  if (can.view_independent && !can.resizes) return 1;
  const uint32_t coarse = motion_.divisor(whole_pixels(), divisor_);
  if (moves() || (can.resizes && scene_moved_ && sent_divisor_ == 0)) {
    // What was measured of those is a picture whose light rests.
    return can.resizes ? std::max(coarse, 2u) : coarse;
  }
  if (can.resizes) return 1;
  const double seconds = motion_.expected_seconds(whole_pixels());
  return sent_divisor_ == 0 && (seconds < 0 || seconds > quick_seconds) ? coarse : 1;
}

bool ViewSide::reached_budget(const RenderSession& session) const {
  const RenderBudget& budget = around_.budget;
  return session.last().converged || (budget.iterations > 0 && session.iterations() >= budget.iterations) ||
         (budget.samples > 0 && session.last().samples >= budget.samples) ||
         (budget.seconds > 0 && sessions_.seconds(divisor_) >= budget.seconds);
}

void ViewSide::work() {
  const Stopwatch working;
  if (!stands_in() || !show_stand_in(hub_.wants_picture())) iterate();
  stage_ = Stage::rendering;
  spent_ += working.seconds();
}

void ViewSide::iterate() {
  const bool light_rests = this->light_rests();
  const uint32_t divisor = choose_divisor();
  session_ = nullptr;
  RenderSession& session = sessions_.at(divisor, light_rests);
  session_ = &session;
  standing_in_ = false;
  if (divisor != divisor_) unseen_seconds_ = 0;
  divisor_ = divisor;
  stage_ = Stage::rendering;
  const uint64_t before = session.iterations(), samples_before = session.last().samples;
  const Stopwatch watch;
  if (!reached_budget(session))
    session.iterate();
  else if (divisor != 1)
    hub_.wait(nap);
  done_ = divisor == 1 && reached_budget(session);
  if (session.last().samples > 0 && !light_rests) scene_moved_ = false;
  if (is_picture_due(session)) send_picture(session);
  // Where light can rest, iterations in which it does not are of light, too.
  if (session.iterations() == before || (!light_rests && sessions_.type().info().capabilities.resizes)) return;
  unseen_seconds_ += watch.seconds();
  const IterationResult last = session.last();
  const bool is_part = last.samples == samples_before && (divisor == 1 || !last.visible);
  if (is_part && !MotionSize::is_slow(unseen_seconds_, divisor)) return;  // the next camera may come before the rest
  motion_.measured(unseen_seconds_, double{1} * session.settings().width * session.settings().height, divisor_);
  unseen_seconds_ = 0;
}

bool ViewSide::rest() {
  stage_ = failed_ ? Stage::failed : done_ ? Stage::done : around_.request.paused ? Stage::paused : Stage::waiting;
  if (!session_ || standing_in_ || !is_picture_due(*session_)) return false;
  send_picture(*session_);
  return true;
}

bool ViewSide::set_time(double seconds) {
  session_ = nullptr;
  stand_in_.clear();  // its scene moves
  if (!sessions_.set_time(seconds)) return false;
  begin_picture();
  scene_moved_ = true;
  return true;
}

RenderSession* ViewSide::whole() { return session_ && divisor_ == 1 && !standing_in_ ? session_ : nullptr; }

/// Pictures get a small share of the time, except for the first of each state; nobody's picture is not made.
bool ViewSide::is_picture_due(const RenderSession& session) const {
  const IterationResult last = session.last();
  if (last.samples == 0 && !last.visible) return false;
  // A player asks for the next time once there is a picture: without this none would ever have all of its light.
  if (last.samples == 0 && scene_moved_ && since_sent_.seconds() < longest_wait) return false;
  if (sent_divisor_ == divisor_ && sent_iterations_ == session.iterations()) return false;
  if (!hub_.wants_picture()) return false;
  if (sent_divisor_ == 0 || (sent_divisor_ != 1 && divisor_ == 1) || stage_ != Stage::rendering) return true;
  if (divisor_ != 1 && sent_divisor_ == 1) return false;
  const double allowed = serving_at_first + serving_share * since_picture_began_.seconds();
  return since_sent_.seconds() >= shortest_interval && serving_seconds_ + picture_cost_ <= allowed;
}

void ViewSide::send_picture(RenderSession& session) {
  const Stopwatch watch;
  auto film = std::make_unique<Film>(session.settings().width, session.settings().height);
  session.technique().resolve(*film);
  layers_ = layer_names(*film);
  send(session, *film, divisor_, seconds(), sessions_.technique());
  meanwhile_.clear();
  film_ = std::move(film);
  film_number_ = around_.picture_number;
  sent_divisor_ = divisor_;
  sent_iterations_ = session.iterations();
  picture_cost_ = watch.seconds();
  serving_seconds_ += picture_cost_;
  since_sent_.restart();
}

void ViewSide::send(RenderSession& session, const Film& film, uint32_t divisor, double seconds,
                    const ViewTechnique& by) {
  ordered_json header = describe_progress(session, seconds);
  header["picture"] = ++around_.picture_number;
  header["side"] = index_;
  header["by"] = {{"name", by.name}, {"parameters", by.parameters}};
  header["camera_number"] = around_.request.camera_number;
  header["divisor"] = divisor;
  header["layer"] = around_.request.layer;
  header["time"] = session.scene().time;
  hub_.set_picture(index_, around_.picture_number,
                   encode_film(std::move(header), film, around_.request.layer, around_.exposure));
}

ordered_json ViewSide::status(const std::vector<ViewTechnique>& others) {
  const ViewRequest& request = around_.request;
  ordered_json status = {
      {"stage", stage_name(stage_)}, {"layers", layers_}, {"refusal", refusal_}, {"failure", failure_}};
  status["meanwhile"] = meanwhile_;
  status["wanted"] = {{"name", request.sides.at(index_).technique},
                      {"parameters", request.sides.at(index_).parameters}};
  if (stage_ == Stage::preparing) {
    status["preparing"] = {{"text", stage_text_}, {"fraction", stage_fraction_}};
    return status;
  }
  if (!session_) return status;
  status["running"] = describe_running(sessions_.technique(), *session_);
  if (standing_in_) {
    status["divisor"] = stand_in_.divisor();
    return status;
  }
  status["progress"] = describe_progress(*session_, seconds());
  status["machine"] = describe_machine(*session_);
  status["divisor"] = divisor_;
  if (around_.commands && divisor_ == 1) {
    ordered_json commands = ordered_json::array();
    for (const RepeatText& repeat : around_.commands({sessions_.technique(), request.camera, request.scene_camera,
                                                      session_->iterations(), around_.edits, others}))
      commands.push_back({{"name", repeat.name}, {"line", repeat.text}, {"file", repeat.file}});
    status["repeat"] = {{"exact", sessions_.is_fresh(1)}, {"commands", std::move(commands)}};
  }
  return status;
}

}  // namespace lucarium
