// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/scene/scene.h"

// Parts of builtin:atrium, each around its own origin. Lengths in metres.
namespace lucarium::atrium {

inline constexpr float bay = 3.f;             ///< distance of column axes
inline constexpr glm::vec2 half_court{6, 9};  ///< column axes stand on |x| = 6 and |z| = 9
inline constexpr float aisle = 3.f;           ///< from the column axes to the wall's axis
inline constexpr float storey = 4.5f;         ///< floor to floor
inline constexpr float springing = 2.7f;      ///< of the arches above the floor
inline constexpr float half_wall = 0.25f;     ///< half the thickness of the arcade
inline constexpr float vault_radius = bay / 2 - half_wall;
inline constexpr float arch_radius = vault_radius - 0.1f;  ///< arches are ribs below the vault
inline constexpr int arch_segments = 24;

/// Fluted shaft with base and capital, from the floor to the springing.
Mesh column_shaft();
/// Plinth and abacus, the square ends of a column.
Mesh column_blocks();
/// One bay of the arcade in the plane z = 0, x = -bay/2 … bay/2, from the springing up to the next floor.
Mesh arcade_wall();
/// Moulding and keystone on the side -Z of that bay.
Mesh arcade_trim();
/// A rib between two bays of the aisle: the arch's soffit and its edges.
Mesh rib();
/// Groin vault over one bay, facing downwards.
Mesh vault();
Mesh baluster();
/// Rail of one bay along X.
Mesh rail();
Mesh lantern_glass();
Mesh lantern_frame();
Mesh fountain_stone();
Mesh fountain_water();
Mesh planter();
Mesh topiary();

}  // namespace lucarium::atrium
