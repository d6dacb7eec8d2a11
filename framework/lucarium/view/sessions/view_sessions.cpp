// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/sessions/view_sessions.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/session/scene_on_device.h"

namespace lucarium {

RenderSettings divided_size(RenderSettings settings, uint32_t divisor) {
  settings.width = (settings.width + divisor - 1) / divisor;
  settings.height = (settings.height + divisor - 1) / divisor;
  return settings;
}

ViewSessions::ViewSessions(std::shared_ptr<Device> device, RenderSession::OnPreparing on_preparing,
                           std::function<bool()> cancel)
    : device_(std::move(device)), on_preparing_(std::move(on_preparing)), cancel_(std::move(cancel)) {}

void ViewSessions::set_scene(std::shared_ptr<SceneOnDevice> scene) {
  clear();
  scene_ = std::move(scene);
}

ViewSessions::Sized ViewSessions::make(const TechniqueType& type, const ViewTechnique& technique,
                                       const RenderSettings& settings, uint32_t divisor) const {
  Sized sized;
  sized.divisor = divisor;
  sized.camera_number = camera_number_;
  sized.session = std::make_unique<RenderSession>(device_, scene_, type, divided_size(settings, divisor),
                                                  technique.parameters, on_preparing_);
  // Light that does not depend on the camera is kept: an iteration of it is never in vain. Nor is a coarse picture: the
  // next camera comes before most of them are done.
  if (divisor == 1 && !type.info().capabilities.view_independent)
    sized.session->scheduler().set_cancel(
        [this] { return interrupt_requested() || (whole_.divisor == 1 && cancel_()); });
  return sized;
}

void ViewSessions::change(const TechniqueType& type, const ViewTechnique& technique, const RenderSettings& settings,
                          uint32_t divisor) {
  Sized made;
  try {
    made = make(type, technique, settings, divisor);
  } catch (const Error& error) {
    if (error.error_class() != ErrorClass::device || empty()) throw;
    clear();
    made = make(type, technique, settings, divisor);
  }
  clear();
  type_ = &type;
  technique_ = technique;
  settings_ = settings;
  slot(divisor) = std::move(made);
}

RenderSession& ViewSessions::at(uint32_t divisor, bool light_rests) {
  Sized& sized = slot(divisor);
  if (!sized.session || (sized.divisor != divisor && !resizes())) {
    sized = {};
    sized = make(*type_, technique_, settings_, resizes() ? 1 : divisor);  // what it plans is for the whole size
  }
  light_rests = light_rests && resizes();
  if (sized.divisor != divisor || sized.light_rests != light_rests)
    sized.camera_number = camera_number_ + 1;  // it has to follow
  if (sized.camera_number != camera_number_) {
    const RenderSettings size = divided_size(settings_, divisor);
    if (resizes())
      sized.session->set_view(settings_.camera, size.width, size.height, light_rests);
    else
      sized.session->set_camera(settings_.camera);
    sized.divisor = divisor;
    sized.light_rests = light_rests;
    sized.camera_number = camera_number_;
    sized.before = 0;  // clocks count from there
    if (type_->info().capabilities.view_independent) sized.fresh = false;
  }
  return *sized.session;
}

void ViewSessions::set_camera(const SceneCamera& camera) {
  settings_.camera = camera;
  ++camera_number_;
}

bool ViewSessions::set_time(double seconds) {
  if (!whole_.session || scene_->sessions > (coarse_.session ? 2 : 1)) return false;
  coarse_ = {};
  at(1);  // what is built again has the plan of the whole size
  try {
    whole_.session->set_time(seconds);
  } catch (const Error& error) {
    if (error.error_class() != ErrorClass::technique) throw;
    return false;
  }
  whole_.session->set_camera(settings_.camera);
  whole_.camera_number = camera_number_;
  whole_.before = 0;
  whole_.fresh = false;
  return true;
}

void ViewSessions::restart() {
  if (whole_.session && resizes()) at(1);  // what begins again has the whole size, and its light goes on
  for (Sized* sized : {&whole_, &coarse_}) {
    if (!sized->session) continue;
    sized->session->restart(settings_.seed);
    sized->before = sized->session->clocks().iterate;
    sized->fresh = true;
  }
}

bool ViewSessions::is_fresh(uint32_t divisor) const { return slot(divisor).fresh; }

double ViewSessions::seconds(uint32_t divisor) const {
  const Sized& sized = slot(divisor);
  return sized.session ? sized.session->clocks().iterate - sized.before : 0;
}

void ViewSessions::clear() {
  whole_ = {};
  coarse_ = {};
  type_ = nullptr;
}

}  // namespace lucarium
