// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/viewer.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/scene/look_at.h"
#include "lucarium/view/film_picture.h"
#include "lucarium/view/status.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr double settled_seconds = 0.2;       // after a move, before the whole size is rendered
constexpr double quick_seconds = 0.3;         // a first picture that takes longer comes coarse before
constexpr double serving_share = 0.04;        // of the time, for pictures
constexpr double serving_at_first = 0.25;     // [s] for a new picture, beside that share
constexpr double shortest_interval = 0.04;    // [s] between pictures while nothing moves
constexpr double report_interval = 0.25;      // [s]
constexpr double patience_without_page = 60;  // [s] then rendering waits
constexpr std::chrono::milliseconds nap{50};

double seconds_since(std::chrono::steady_clock::time_point time) {
  if (time == std::chrono::steady_clock::time_point{}) return INFINITY;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - time).count();
}

}  // namespace

Viewer::Viewer(std::shared_ptr<Device> device, Scene scene, const TechniqueRegistry& registry, ViewerOptions options,
               ViewHub& hub)
    : device_(std::move(device)),
      cameras_(scene.cameras),
      bounds_(scene.bounds()),
      exposure_(scene.exposure),
      registry_(registry),
      options_(std::move(options)),
      hub_(hub),
      welcome_(describe_view(scene, registry, options_.techniques, options_.settings)),
      sessions_(
          device_, std::move(scene),
          [this](double fraction, const std::string& stage) {
            stage_ = Stage::preparing;
            stage_text_ = stage;
            stage_fraction_ = fraction;
            report(false);
          },
          [this] { return stopped_ || hub_.changes() != changes_; }) {
  hub_.set_welcome(welcome_);
  hub_.set_request([this](ViewRequest& request) {
    request.technique = options_.techniques.front().name;
    request.parameters = options_.techniques.front().parameters;
    ++request.technique_number;
    ++request.camera_number;
  });
}

bool Viewer::should_stop() const { return stopped_ || interrupt_requested(); }

void Viewer::run() {
  while (!should_stop()) {
    try {
      step();
    } catch (const Error& error) {
      if (error.error_class() == ErrorClass::interrupted) break;
      fail(error.what());
    } catch (const std::exception& error) {
      fail(error.what());
    }
  }
}

void Viewer::step() {
  changes_ = hub_.changes();
  follow(hub_.request());
  if (has_work()) {
    work();
  } else {
    stage_ = failed_ ? Stage::failed : done_ ? Stage::done : request_.paused ? Stage::paused : Stage::waiting;
    if (session_ && is_picture_due(*session_)) {
      send_picture(*session_);
      report(true);  // its layers
    }
    hub_.wait(nap);
  }
  send_files();
  report(false);
}

void Viewer::follow(const ViewRequest& request) {
  const ViewRequest before = request_;
  request_ = request;
  if (request.camera_number != before.camera_number) follow_camera(request);
  if (request.technique_number != before.technique_number) follow_technique(request);
  if (request.restart_number != before.restart_number) {
    failed_ = false;
    sessions_.restart();
    begin_picture();
  }
  if (request.layer_number != before.layer_number) {  // the picture is there, it only has to be sent
    sent_iterations_ = UINT64_MAX;
    serving_seconds_ = 0;
  }
}

void Viewer::follow_camera(const ViewRequest& request) {
  const SceneCamera& base = cameras_[std::min<size_t>(request.scene_camera, cameras_.size() - 1)];
  camera_ = base;
  if (request.camera) {
    const CameraKey& key = *request.camera;
    camera_ = look_at_camera("", key.eye, key.target, key.vfov_degrees);
    camera_.perspective = base.perspective;
    camera_.xmag = base.xmag;
    camera_.ymag = base.ymag;
  }
  sessions_.set_camera(camera_);
  begin_picture();
}

void Viewer::follow_technique(const ViewRequest& request) {
  const ViewTechnique wanted{request.technique, request.parameters};
  try {
    take(wanted);
    refusal_.clear();
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::interrupted) throw;
    refuse(wanted, error);
  }
}

/// Builds its session, whose first picture is coarse unless the whole one comes as quickly.
void Viewer::take(const ViewTechnique& technique) {
  const TechniqueType& type = registry_.find(technique.name);
  if (sessions_.empty() || sessions_.technique().name != technique.name) motion_.forget();
  stage_ = Stage::preparing;
  stage_text_ = "preparing";
  report(true);
  const uint32_t divisor = type.info().capabilities.view_independent ? 1 : motion_.divisor(whole_pixels(), 0);
  sessions_.change(type, technique, settings(), divisor);
  session_ = nullptr;
  failed_ = false;
  begin_picture();
}

/// What ran before goes on, where there is anything.
void Viewer::refuse(const ViewTechnique& technique, const Error& error) {
  refusal_ = error.what();
  log_info("{} was refused: {}", technique.name, error.what());
  if (sessions_.empty()) {
    failed_ = true;
    session_ = nullptr;
  }
  report(true);
}

RenderSettings Viewer::settings() const {
  RenderSettings settings = options_.settings;
  settings.camera = camera_;
  return settings;
}

double Viewer::whole_pixels() const { return double{1} * options_.settings.width * options_.settings.height; }

void Viewer::begin_picture() {
  done_ = false;
  sent_divisor_ = 0;
  serving_seconds_ = 0;
  since_picture_began_.restart();
}

bool Viewer::has_work() const {
  if (failed_ || sessions_.empty() || done_) return false;
  if (hub_.seconds_without_pages() > patience_without_page && sent_divisor_ == 1) return false;
  return !request_.paused || sent_divisor_ != 1;
}

uint32_t Viewer::choose_divisor() const {
  if (sessions_.type().info().capabilities.view_independent) return 1;
  const uint32_t coarse = motion_.divisor(whole_pixels(), divisor_);
  if (seconds_since(request_.camera_time) < settled_seconds) return coarse;
  const double seconds = motion_.expected_seconds(whole_pixels());
  return sent_divisor_ == 0 && (seconds < 0 || seconds > quick_seconds) ? coarse : 1;
}

bool Viewer::reached_budget(const RenderSession& session) const {
  const RenderBudget& budget = options_.budget;
  return session.last().converged || (budget.iterations > 0 && session.iterations() >= budget.iterations) ||
         (budget.samples > 0 && session.last().samples >= budget.samples) ||
         (budget.seconds > 0 && session.clocks().iterate >= budget.seconds);
}

void Viewer::work() {
  const uint32_t divisor = choose_divisor();
  session_ = nullptr;
  RenderSession& session = sessions_.at(divisor);
  session_ = &session;
  divisor_ = divisor;
  stage_ = Stage::rendering;
  if (!reached_budget(session)) {
    const uint64_t before = session.iterations();
    const Stopwatch watch;
    session.iterate();
    if (session.iterations() > before)
      motion_.measured(watch.seconds(), double{1} * session.settings().width * session.settings().height);
  } else if (divisor != 1) {
    hub_.wait(nap);
  }
  done_ = divisor == 1 && reached_budget(session);
  if (is_picture_due(session)) send_picture(session);
}

/// Pictures get a small share of the time, except for the first of each state; nobody's picture is not made.
bool Viewer::is_picture_due(const RenderSession& session) const {
  const IterationResult last = session.last();
  if (last.samples == 0 && !last.visible) return false;
  if (sent_divisor_ == divisor_ && sent_iterations_ == session.iterations()) return false;
  if (!hub_.wants_picture()) return false;
  if (sent_divisor_ == 0 || (sent_divisor_ != 1 && divisor_ == 1) || stage_ != Stage::rendering) return true;
  if (divisor_ != 1 && sent_divisor_ == 1) return false;
  const double allowed = serving_at_first + serving_share * since_picture_began_.seconds();
  return since_sent_.seconds() >= shortest_interval && serving_seconds_ + picture_cost_ <= allowed;
}

void Viewer::send_picture(RenderSession& session) {
  const Stopwatch watch;
  Film film(session.settings().width, session.settings().height);
  session.technique().resolve(film);
  layers_ = layer_names(film);
  ordered_json header = describe_progress(session);
  header["picture"] = ++picture_number_;
  header["camera_number"] = request_.camera_number;
  header["divisor"] = divisor_;
  header["layer"] = request_.layer;
  hub_.set_picture(picture_number_, encode_film(std::move(header), film, request_.layer, exposure_));
  sent_divisor_ = divisor_;
  sent_iterations_ = session.iterations();
  picture_cost_ = watch.seconds();
  serving_seconds_ += picture_cost_;
  since_sent_.restart();
}

void Viewer::send_files() {
  for (const ViewSave& save : hub_.take_saves()) {
    try {
      if (!session_ || sent_divisor_ != 1) throw_error(ErrorClass::usage, "there is no whole picture yet");
      hub_.send_file(save.page, encode_file(save.kind, save.exposure, session_->resolve()));
    } catch (const Error& error) {
      hub_.send_error(save.page, error.what());
    }
  }
}

const char* Viewer::stage_name(Stage stage) {
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

ordered_json Viewer::status() const {
  ordered_json status = {{"stage", stage_name(stage_)}, {"paused", request_.paused}, {"layer", request_.layer},
                         {"layers", layers_},           {"refusal", refusal_},       {"failure", failure_}};
  status["wanted"] = {{"name", request_.technique}, {"parameters", request_.parameters}};
  ordered_json camera = to_json(request_.camera ? *request_.camera : view_key_of(camera_, bounds_));
  camera["number"] = request_.camera_number;
  camera["of_scene"] = request_.camera ? ordered_json(nullptr) : ordered_json(request_.scene_camera);
  status["camera"] = std::move(camera);
  if (stage_ == Stage::preparing) {
    status["preparing"] = {{"text", stage_text_}, {"fraction", stage_fraction_}};
    return status;
  }
  if (!session_) return status;
  status["running"] = describe_running(sessions_.technique(), *session_);
  status["progress"] = describe_progress(*session_);
  status["machine"] = describe_machine(*session_);
  status["divisor"] = divisor_;
  if (options_.commands && divisor_ == 1) {
    const std::optional<CameraKey> key = request_.camera;
    ordered_json commands = ordered_json::array();
    for (const auto& [name, line] :
         options_.commands({sessions_.technique(), key, request_.scene_camera, session_->iterations()}))
      commands.push_back({{"name", name}, {"line", line}});
    status["repeat"] = {{"exact", sessions_.is_fresh(1)}, {"commands", std::move(commands)}};
  }
  return status;
}

void Viewer::report(bool now) {
  if (!now && stage_ == reported_ && since_report_.seconds() < report_interval) return;
  // Nothing changes any more: pages know it.
  if (!now && stage_ == reported_ && stage_ != Stage::rendering && stage_ != Stage::preparing &&
      reported_changes_ == changes_)
    return;
  reported_ = stage_;
  reported_changes_ = changes_;
  since_report_.restart();
  hub_.set_status(dump_line({{"status", status()}}));
}

void Viewer::fail(const std::string& why) {
  failed_ = true;
  failure_ = why;
  session_ = nullptr;
  sessions_.clear();
  stage_ = Stage::failed;
  report(true);
}

}  // namespace lucarium
