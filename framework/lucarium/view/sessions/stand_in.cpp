// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/sessions/stand_in.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/session/scene_on_device.h"
#include "lucarium/view/sessions/view_sessions.h"

namespace lucarium {

namespace {

constexpr double longest_wait = 0.3;  // [s] without a picture

double pixels_of(const RenderSettings& settings) { return double{1} * settings.width * settings.height; }

}  // namespace

StandIn::StandIn(std::shared_ptr<Device> device, RenderSession::OnPreparing on_preparing)
    : device_(std::move(device)), on_preparing_(std::move(on_preparing)) {}

void StandIn::clear() {
  session_.reset();
  divisor_ = 0;
}

void StandIn::set_scene(std::shared_ptr<SceneOnDevice> scene) {
  clear();
  scene_ = std::move(scene);
  motion_.forget();
  fails_ = false;
}

bool StandIn::is_wanted_for(const TechniqueType& type, const ViewTechnique& wanted,
                            const RenderSettings& settings) const {
  const std::unique_ptr<Technique> technique = type.create();
  technique->parameters().set_all(wanted.parameters);
  return technique->estimate_seconds(scene_->scene, settings, compute_power(device_->info())) > longest_wait;
}

void StandIn::make(const TechniqueRegistry& registry, const RenderSettings& settings, uint32_t divisor) {
  clear();
  session_ = std::make_unique<RenderSession>(device_, scene_, registry.find(technique), divided_size(settings, divisor),
                                             ViewTechnique{}.parameters, on_preparing_);
  divisor_ = divisor;
  seen_number_ = camera_number_;
}

RenderSession* StandIn::render(const TechniqueRegistry& registry, const RenderSettings& settings) {
  if (fails_) return nullptr;
  try {
    const uint32_t divisor = std::max(motion_.divisor(pixels_of(settings), divisor_), 2u);  // coarse in any case
    has_made_ = !session_ || divisor != divisor_;
    if (has_made_) make(registry, settings, divisor);
    if (seen_number_ != camera_number_) session_->set_camera(settings.camera);
    seen_number_ = camera_number_;
    session_->iterate();
    return session_.get();
  } catch (const Error& error) {
    clear();
    if (error.error_class() == ErrorClass::interrupted) throw;
    log_info("nothing stands in: {}", error.what());
    fails_ = true;
    return nullptr;
  }
}

void StandIn::measured(double seconds) {
  if (session_ && !has_made_) motion_.measured(seconds, pixels_of(session_->settings()), divisor_);
}

}  // namespace lucarium
