// SPDX-License-Identifier: Apache-2.0
// Scenes of the conformance kit. Those with a closed form have it written above them.
#pragma once
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"
#include "lucarium/technique/capabilities.h"

namespace lucarium::check {

inline constexpr float albedo = 0.5f;  ///< of every diffuse surface of the closed forms

/// A wide Lambertian floor under one light, seen from straight above within a millimetre, so that every pixel shows the
/// radiance of one point: albedo · E / π.
struct LitFloor {
  Scene scene;
  double irradiance = 0;  ///< E at that point [lx]
};
LitFloor make_lit_floor(LightKind light);

/// The inside of a closed box whose walls all shine with radiance 1 and reflect `albedo`: n scatterings add albedo^n.
Scene make_shining_box();

// ---- for comparisons with the reference

/// A box or a screen of the named material on a diffuse floor, beside a diffuse box, under a lamp of the named kind or
/// an uneven sky.
Scene make_material_scene(MaterialKind material, LightKind light);

/// Boxes of two materials that the uneven sky is seen in, or through.
Scene make_sky_scene(const std::vector<MaterialKind>& materials);

/// A two-sided lamp and two-sided sheets, all seen from behind.
Scene make_sides_scene(const std::vector<MaterialKind>& sheets);

/// A box on a floor, both diffuse below a smooth coat: opaque, with an ideal and a diffuse lobe together.
Scene make_lobes_scene(LightKind light);

// ----

/// Boxes on a floor for scene changes: instance 0 the floor, 1 a box that may move, 2 one that may deform. Lit by the
/// named kind of light.
Scene make_changing_scene(LightKind light);

}  // namespace lucarium::check
