// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "lucarium/session/session.h"
#include "lucarium/session/walk.h"

namespace lucarium::app {

/// Walks, and says the seconds of each frame and the relMSE of those with a reference. Throws Error{interrupted} when
/// it was not walked to its end.
nlohmann::ordered_json walk_json(RenderSession& session, const Walk& request);

}  // namespace lucarium::app
