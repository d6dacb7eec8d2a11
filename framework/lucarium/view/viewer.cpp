// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/viewer.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/look_at.h"
#include "lucarium/session/scene_on_device.h"
#include "lucarium/view/film_picture.h"
#include "lucarium/view/status.h"

namespace lucarium {

using nlohmann::ordered_json;
using Stage = ViewSide::Stage;

namespace {

constexpr double report_interval = 0.25;  // [s]
constexpr std::chrono::milliseconds idle{50};

}  // namespace

Viewer::Viewer(std::shared_ptr<Device> device, Scene scene, const TechniqueRegistry& registry, ViewerOptions options,
               ViewHub& hub)
    : registry_(registry),
      named_(std::move(options.techniques)),
      hub_(hub),
      around_{
          std::move(device), options.settings, options.budget, std::move(options.commands), scene.exposure, {}, {}, 0},
      edited_(std::move(options.edited)),
      truth_(around_, registry, [this] { return stopped_ || hub_.changes() != changes_; }) {
  hub_.set_welcome(describe_view(scene, registry, named_, around_.settings));
  for (uint32_t index = 0; index < view_sides; ++index) {
    sides_[index] = std::make_unique<ViewSide>(
        around_, hub, index, [this] { report(false); }, [this] { return stopped_ || hub_.changes() != changes_; });
  }
  replace_scene(std::move(scene), false);
  hub_.set_request([this](ViewRequest& request) {
    for (uint32_t index = 0; index < view_sides; ++index) {
      const ViewTechnique& technique = named_[std::min<size_t>(index, named_.size() - 1)];
      request.sides[index] = {technique.name, technique.parameters, 1};
    }
    ++request.camera_number;
  });
}

bool Viewer::should_stop() const { return stopped_ || interrupt_requested(); }

void Viewer::run() {
  while (!should_stop()) {
    try {
      step();
    } catch (const std::exception& error) {  // what no side could be blamed for
      for (const auto& side : sides_) side->fail(error.what());
    }
  }
}

/// What is thrown is the failure of that side alone.
void Viewer::attempt(ViewSide& side, const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::interrupted) return;
    side.fail(error.details().empty() ? error.what() : fmt::format("{}\n{}", error.what(), error.details()));
    report(true);
  } catch (const std::exception& error) {
    side.fail(error.what());
    report(true);
  }
}

void Viewer::step() {
  changes_ = hub_.changes();
  follow(hub_.request());
  ViewSide* const chosen = next_side();
  if (is_truth_next(chosen)) {
    truth_.work();
    if (!truth_.is_on()) end_truth();
  } else if (chosen) {
    attempt(*chosen, [&] {
      chosen->work();
      if (truth_.watch(*chosen)) report(true);
    });
  } else {
    hub_.wait(idle);
  }
  for (uint32_t index = 0; index < sides(); ++index) {
    ViewSide& side = *sides_[index];
    if (side.has_work()) continue;
    attempt(side, [&] {
      const bool has_sent = side.rest();  // then its layers are known
      if (truth_.watch(side) || has_sent) report(true);
    });
  }
  send_flip();
  send_files();
  report(false);
}

/// The side that has worked least on its picture: both have the same share of the device, whatever their iterations
/// take.
ViewSide* Viewer::next_side() {
  ViewSide* next = nullptr;
  for (uint32_t index = 0; index < sides(); ++index) {
    ViewSide* const side = sides_[index].get();
    if (side->has_work() && (!next || side->spent() < next->spent())) next = side;
  }
  return next;
}

/// While the camera moves the pictures come first; then the reference has the share of one technique.
bool Viewer::is_truth_next(const ViewSide* side) const {
  if (!truth_.has_work() || around_.request.paused || hub_.pages() == 0) return false;
  return !side || (side->film_divisor() == 1 && truth_.spent() < side->spent());
}

/// The reference has failed: it can be asked for again.
void Viewer::end_truth() {
  hub_.set_request([](ViewRequest& request) { request.reference = false; });
  around_.request.reference = false;
  report(true);
}

void Viewer::follow(const ViewRequest& request) {
  const ViewRequest before = around_.request;
  around_.request = request;
  if (request.scene_number != before.scene_number) follow_scene();
  if (request.camera_number != before.camera_number) follow_camera(request);
  for (uint32_t index = 0; index < view_sides; ++index) follow_side(index, before);
  if (request.reference != before.reference) {
    truth_.switch_to(request.reference);
    truth_.catch_up(sides_[0]->spent());
    report(true);
  }
  if (request.inspect_number != before.inspect_number) {
    inspector_.look(around_, *scene_);
    report(true);
  }
}

/// A change of time alone is made in place, where the session that is there can follow; all else is a new scene.
void Viewer::follow_scene() {
  const SceneEdits& edits = around_.request.edits;
  SceneEdits same = around_.edits;
  same.seconds = edits.seconds;
  try {
    if (!(same == edits) || !move_scene(edits.seconds.value_or(0))) {
      Scene scene = edited_(edits);
      std::array<ViewTechnique, view_sides> running;  // what is wanted may have been refused
      for (uint32_t index = 0; index < view_sides; ++index) {
        const ViewRequest::Side& wanted = around_.request.sides[index];
        running[index] =
            sides_[index]->empty() ? ViewTechnique{wanted.technique, wanted.parameters} : sides_[index]->technique();
      }
      const bool moved = edits.seconds != around_.edits.seconds;
      around_.edits = edits;
      replace_scene(std::move(scene), moved);
      for (uint32_t index = 0; index < sides(); ++index)
        attempt(*sides_[index], [&] { sides_[index]->take(registry_, running[index]); });
    }
    scene_refusal_.clear();
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::interrupted) return;
    scene_refusal_ = error.what();
    take_back_edits();
  }
  report(true);
}

/// What was refused is not asked for again with the next change.
void Viewer::take_back_edits() {
  hub_.set_request([this](ViewRequest& request) {
    if (request.scene_number == around_.request.scene_number) request.edits = around_.edits;
  });
  around_.request.edits = around_.edits;
  hub_.set_scene(describe_scene(scene_->scene, around_.edits));
}

bool Viewer::move_scene(double seconds) {
  truth_.begin();
  if (sides() > 1 || !sides_[0]->set_time(seconds)) return false;
  around_.edits.seconds = around_.request.edits.seconds;
  take_cameras(scene_->scene);  // pages know the rest, and hear of the time by the status
  return true;
}

void Viewer::replace_scene(Scene scene, bool moved) {
  take_scene(scene);
  scene_ = share_scene(std::move(scene));
  truth_.begin(scene_);
  for (const auto& side : sides_) side->set_scene(scene_, moved);
}

void Viewer::take_scene(const Scene& scene) {
  hub_.set_scene(describe_scene(scene, around_.edits));
  take_cameras(scene);
}

void Viewer::take_cameras(const Scene& scene) {
  cameras_ = scene.cameras;
  bounds_ = scene.bounds();
  around_.exposure = scene.exposure;
  follow_camera(around_.request);
}

void Viewer::follow_camera(const ViewRequest& request) {
  const SceneCamera& base = cameras_[std::min<size_t>(request.scene_camera, cameras_.size() - 1)];
  SceneCamera& camera = around_.settings.camera;
  camera = base;
  if (request.camera) {
    const CameraKey& key = *request.camera;
    camera = look_at_camera("", key.eye, key.target, key.vfov_degrees);
    camera.perspective = base.perspective;
    camera.xmag = base.xmag;
    camera.ymag = base.ymag;
  }
  for (const auto& side : sides_) side->follow_camera();
  truth_.begin();
  inspector_.forget();
}

/// The second side keeps nothing while it is not seen: its memory may be another's.
void Viewer::follow_side(uint32_t index, const ViewRequest& before) {
  ViewSide& side = *sides_[index];
  const ViewRequest& now = around_.request;
  if (index > 0 && !now.beside) {
    if (before.beside) side.clear();
    return;
  }
  const ViewRequest::Side& wanted = now.sides[index];
  const bool appears = index > 0 && !before.beside;
  if (appears || wanted.number != before.sides[index].number) {
    attempt(side, [&] { side.take(registry_, {wanted.technique, wanted.parameters}); });
    for (uint32_t other = 0; other < sides(); ++other) side.catch_up(other == index ? 0 : sides_[other]->spent());
    side.catch_up(truth_.spent());
    report(true);
  }
  if (now.restart_number != before.restart_number && !side.empty()) {
    truth_.forget(side.technique());
    attempt(side, [&] { side.restart(); });
    side.catch_up(truth_.spent());
  }
  if (now.layer_number != before.layer_number) side.show_again();  // the picture is there, it only has to be sent
}

void Viewer::send_flip() {
  if (!around_.request.beside || !around_.request.flip || !hub_.wants_picture()) return;
  const std::optional<std::string> picture =
      flip_.between(*sides_[0], *sides_[1], around_.exposure, around_.picture_number + 1);
  if (picture) hub_.set_picture(view_sides, ++around_.picture_number, *picture);
}

void Viewer::send_files() {
  for (const ViewSave& save : hub_.take_saves()) {
    try {
      RenderSession* const session = sides_[0]->whole();  // whether a page has seen it or not
      if (!session || (session->last().samples == 0 && !session->last().visible))
        throw_error(ErrorClass::usage, "there is no whole picture yet");
      hub_.send_file(save.page, encode_file(save.kind, save.exposure, session->resolve()));
    } catch (const Error& error) {
      hub_.send_error(save.page, error.what());
    }
  }
}

ordered_json Viewer::status() {
  const ViewRequest& request = around_.request;
  ordered_json status = {{"paused", request.paused},
                         {"layer", request.layer},
                         {"beside", !request.beside ? "none"
                                    : request.flip  ? "flip"
                                                    : "pictures"}};
  ordered_json camera = to_json(request.camera ? *request.camera : view_key_of(around_.settings.camera, bounds_));
  camera["number"] = request.camera_number;
  camera["of_scene"] = request.camera ? ordered_json(nullptr) : ordered_json(request.scene_camera);
  status["camera"] = std::move(camera);
  status["sides"] = ordered_json::array();
  for (uint32_t index = 0; index < sides(); ++index) {
    std::vector<ViewTechnique> others;
    for (uint32_t other = 0; other < sides(); ++other)
      if (other != index && !sides_[other]->empty()) others.push_back(sides_[other]->technique());
    status["sides"].push_back(sides_[index]->status(others));
  }
  status["truth"] = truth_.status();
  status["time"] = scene_->scene.time;
  status["scene_refusal"] = scene_refusal_;
  status["inspected"] =
      request.inspect_number == 0 ? ordered_json(nullptr) : inspector_.describe(sides_, sides(), is_quiet());
  return status;
}

/// Nothing changes any more: pages know it.
bool Viewer::is_quiet() const {
  if (truth_.has_work() && !around_.request.paused) return false;
  for (uint32_t index = 0; index < sides(); ++index) {
    const Stage stage = sides_[index]->stage();
    if (stage == Stage::rendering || stage == Stage::preparing) return false;
  }
  return true;
}

void Viewer::report(bool now) {
  const bool quiet = is_quiet(), ended = quiet && !reported_quiet_;
  if (!now && !ended && since_report_.seconds() < report_interval) return;
  if (!now && quiet && reported_quiet_ && reported_changes_ == changes_) return;
  reported_quiet_ = quiet;
  reported_changes_ = changes_;
  since_report_.restart();
  hub_.set_status(dump_line({{"status", status()}}));
}

}  // namespace lucarium
