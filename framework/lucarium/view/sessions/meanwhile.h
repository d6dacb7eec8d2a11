// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/session/session.h"
#include "lucarium/view/edits/view_technique.h"

namespace lucarium {

/// Of the picture that is seen meanwhile.
inline constexpr const char* meanwhile_technique = "path_tracing";
inline constexpr uint32_t meanwhile_divisor = 4;

/// The first sample of a coarse picture of the scene, by path_tracing, for techniques that are expected to prepare
/// themselves for longer than people like to wait. Null where the wanted technique does not, or path_tracing cannot.
std::unique_ptr<RenderSession> render_meanwhile(const std::shared_ptr<Device>& device,
                                                const std::shared_ptr<SceneOnDevice>& scene,
                                                const TechniqueRegistry& registry, const ViewTechnique& wanted,
                                                const RenderSettings& settings,
                                                const RenderSession::OnPreparing& on_preparing);

}  // namespace lucarium
