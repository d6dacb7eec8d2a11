// SPDX-License-Identifier: Apache-2.0
// What pages hear, as JSON.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/session/session.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/view/sessions/view_sessions.h"

namespace lucarium {

/// Where a camera stands: the key with which look_at_camera() gives it again, without its roll. The target lies as far
/// away as the middle of the scene.
CameraKey view_key_of(const SceneCamera& camera, const Bounds& bounds);

/// {"cameras": [{"name", "eye", "target", "vfov"}], "techniques": […], "named": […], "size", "exposure"}: what does not
/// change. `named`: the techniques of the command line.
std::string describe_view(const Scene& scene, const TechniqueRegistry& registry,
                          const std::vector<ViewTechnique>& named, const RenderSettings& settings);

/// The present values of a session's parameters, what it lacks on this scene, and its light paths simplified for this
/// scene: "paths", what differs from all of them; "light": false where it shows none.
nlohmann::ordered_json describe_running(const ViewTechnique& technique, RenderSession& session);

/// {"iterations", "samples", "seconds", "progress", "phase", "converged"}
nlohmann::ordered_json describe_progress(const RenderSession& session, double seconds);

/// Time per pass [s] since the last change, device memory by owner [bytes], the technique's counters.
nlohmann::ordered_json describe_machine(RenderSession& session);

nlohmann::ordered_json to_json(const glm::vec3& v);
nlohmann::ordered_json to_json(const CameraKey& key);

/// One line of JSON; bytes that are no UTF-8 are replaced.
std::string dump_line(const nlohmann::ordered_json& json);

}  // namespace lucarium
