// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <vector>

#include "lucarium/scene/device/emission.h"
#include "lucarium/scene/device/light_tree.h"
#include "lucarium/scene/scene.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// How light samples are shared out among the entries of the mixture.
enum class LightChoice {
  tree,    ///< by what each may send to the lit point (LightTree); what chooses for no point does so by power
  power,   ///< by emitted power, with a share of 10 % spread evenly
  uniform  ///< the same for every entry, whatever its kind
};

/// Share of light samples that LightChoice::power spreads evenly: a defensive mixture (Hesterberg 1995), so that a dim
/// lamp next to the eye is found at no less than a tenth of its uniform rate, at a cost of at most 1/0.9 in the
/// variance of the bright ones.
inline constexpr double even_light_share = 0.1;

/// Where all lights are of one kind, and no more than this have a place, LightChoice::tree chooses by power: a tree
/// takes a third of the time of shading a vertex, and where a lamp is two triangles there is nothing to choose.
inline constexpr int few_lights = 4;

/// The alias table from which one light is drawn per vertex: of those that are included, the others have probability 0.
/// Meaningless when none is included.
std::vector<AliasEntry> light_choice_table(const std::vector<Light>& lights, LightChoice choice,
                                           const std::function<bool(const Light&)>& is_included);

/// scene_lights, what chooses among them, and scene_triangle_lights: first the punctual lights in their order, then
/// emissive triangles in world order, last the environment. Entries that emit nothing are left out (of a textured
/// triangle: black over the whole footprint), as are triangles that rays cannot hit.
struct LightList {
  std::vector<Light> lights;
  std::vector<AliasEntry> table;
  LightTree tree;
  std::vector<uint> triangle_lights;
  uint environment_light = LUCARIUM_NONE;
  /// From this distance on no light sample of a triangle that is chosen from the table brings a point more than pi
  /// times its radiance: the largest sqrt(A / pi P) of area A and probability P [m]; of one lamp alone the radius of
  /// the disc of its area. 0: none. Of trees it is no bound: what they choose brings about what all lights do together.
  float reach = 0;
};

/// Makes light lists of one scene; remembers the mean radiance of textured triangles between them, since only a change
/// of materials alters it.
class LightListBuilder {
 public:
  /// Powers [lm], mean of the channels: point 4 π I; spot I times its solid angle; directional π R² E; triangle π A L,
  /// twice that if two-sided; environment π R² ∫ L dω. R is the radius of the scene's bounding sphere.
  LightList build(const Scene& scene, float scene_radius, LightChoice choice);
  /// Materials changed.
  void drop_radiance() { radiance_.clear(); }

 private:
  void add_triangles(const Scene& scene, LightList& list, std::vector<LightBounds>& bounds);
  std::vector<std::vector<glm::vec3>> radiance_;  ///< per instance that emits: mean radiance of its triangles
};

/// Flux of a punctual light [lm]; for a directional one through a disc of radius `scene_radius`.
glm::vec3 light_flux(const SceneLight& light, float scene_radius);

}  // namespace lucarium
