// SPDX-License-Identifier: Apache-2.0
// The checks by kind; check_list.cpp names them. Each returns its outcome or throws what the technique threw.
#pragma once
#include "lucarium/conformance/check_context.h"

namespace lucarium::check {

// ---- declarations (declaration_checks.cpp)
Outcome check_declaration(CheckContext& context);
Outcome check_parameters(CheckContext& context);
Outcome check_layers(CheckContext& context);
Outcome check_finite(CheckContext& context);

// ---- repetition (repeat_checks.cpp)
Outcome check_seed(CheckContext& context);
Outcome check_reset(CheckContext& context);
Outcome check_observing(CheckContext& context);
Outcome check_threads(CheckContext& context);
Outcome check_oclgrind(CheckContext& context);

// ---- light that does not depend on the camera (view_checks.cpp)
Outcome check_view(CheckContext& context);
Outcome check_state(CheckContext& context);

// ---- changes (change_checks.cpp)
Outcome check_camera_cost(CheckContext& context);
Outcome check_change(CheckContext& context, ChangeKind kind);
Outcome check_alpha_change(CheckContext& context);

// ---- limits (limit_checks.cpp)
Outcome check_memory(CheckContext& context);
Outcome check_estimate(CheckContext& context);
Outcome check_iterations(CheckContext& context);
Outcome check_seconds(CheckContext& context);
Outcome check_cancellation(CheckContext& context);

// ---- light (light_checks.cpp, reference_checks.cpp)
Outcome check_light(CheckContext& context, LightKind light);
Outcome check_furnace(CheckContext& context);
Outcome check_shining_box(CheckContext& context);
Outcome check_reference(CheckContext& context, MaterialKind material, LightKind light);
Outcome check_sky(CheckContext& context);
Outcome check_sides(CheckContext& context);
Outcome check_lobes(CheckContext& context);

}  // namespace lucarium::check
