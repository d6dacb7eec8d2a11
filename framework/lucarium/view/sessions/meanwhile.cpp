// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/sessions/meanwhile.h"

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/session/scene_on_device.h"
#include "lucarium/view/sessions/view_sessions.h"

namespace lucarium {

namespace {

constexpr double longest_wait = 0.3;  // [s] without a picture

bool prepares_for_long(const TechniqueType& type, const ViewTechnique& wanted, const Scene& scene,
                       const RenderSettings& settings, const DeviceInfo& device) {
  const std::unique_ptr<Technique> technique = type.create();
  technique->parameters().set_all(wanted.parameters);
  return technique->estimate_seconds(scene, settings, compute_power(device)) > longest_wait;
}

}  // namespace

std::unique_ptr<RenderSession> render_meanwhile(const std::shared_ptr<Device>& device,
                                                const std::shared_ptr<SceneOnDevice>& scene,
                                                const TechniqueRegistry& registry, const ViewTechnique& wanted,
                                                const RenderSettings& settings,
                                                const RenderSession::OnPreparing& on_preparing) {
  try {
    if (!prepares_for_long(registry.find(wanted.name), wanted, scene->scene, settings, device->info())) return nullptr;
    auto session = std::make_unique<RenderSession>(device, scene, registry.find(meanwhile_technique),
                                                   divided_size(settings, meanwhile_divisor),
                                                   ViewTechnique{}.parameters, on_preparing);
    session->iterate();
    return session;
  } catch (const Error& error) {
    if (error.error_class() == ErrorClass::interrupted) throw;
    log_info("nothing is shown meanwhile: {}", error.what());
    return nullptr;
  }
}

}  // namespace lucarium
