// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "budgets/render_budget.h"
#include "lucarium/film/film.h"
#include "lucarium/session/session.h"

namespace lucarium::app {

/// What --json says about one frame (docs/results.md).
nlohmann::ordered_json frame_json(RenderSession& session, const Film& film, const RenderEnd& end, double load_seconds,
                                  double total_seconds, float exposure,
                                  const std::vector<std::filesystem::path>& files);

/// What --json prints: schema lucarium-render-2.
nlohmann::ordered_json summary_json(const nlohmann::ordered_json& frames);

}  // namespace lucarium::app
