// SPDX-License-Identifier: Apache-2.0
// Checks against the path tracer. Declared in checks.h.
#include <algorithm>

#include "lucarium/conformance/block_comparison.h"
#include "lucarium/conformance/check_scenes.h"
#include "lucarium/conformance/checks.h"

namespace lucarium::check {
namespace {

const char* const reference_name = "path_tracing";
constexpr uint64_t reference_samples = 128;  // of one seed
constexpr uint64_t reference_seed = 1000;    // apart from those of the technique

RenderSession reference_session(CheckContext& context, const Scene& scene, const PathSet& set,
                                const TechniqueType& type) {
  RenderSettings settings = context.settings(scene);
  settings.max_bounces = set.max_bounces;
  auto parameters = set.technique_parameters();
  parameters.emplace_back("samples_per_iteration", "16");
  return RenderSession(context.device, scene, type, settings, parameters);
}

/// Those of the kinds that the technique claims.
std::vector<MaterialKind> claimed(const CheckContext& context, std::vector<MaterialKind> kinds) {
  std::erase_if(kinds, [&](MaterialKind kind) { return !context.claims(kind); });
  return kinds;
}

Outcome compare_with_reference(CheckContext& context, const Scene& scene) {
  const auto& types = context.registry.types();
  const auto reference =
      std::find_if(types.begin(), types.end(), [](const TechniqueType& t) { return t.info().name == reference_name; });
  if (reference == types.end()) return {Verdict::skipped, "the technique path_tracing is not installed"};

  const std::unique_ptr<Technique> technique = context.type.create();
  technique->parameters().set_all(context.options.parameters);
  const PathSet set = technique->path_set(scene, context.settings(scene));
  RenderSession mine = context.session(scene);
  RenderSession other = reference_session(context, scene, set, *reference);
  const BlockTest test = compare_seeds(
      [&](uint64_t seed) {
        mine.restart(seed);
        context.run_long(mine);
        return mine.resolve().image();
      },
      [&](uint64_t seed) {
        other.restart(reference_seed + seed);
        other.run({.samples = reference_samples});
        return other.resolve().image();
      },
      context.bias);
  if (test.noise > largest_noise) return {Verdict::skipped, "too noisy to decide: " + test.describe(context.bias)};
  return verdict_of(test.passes(context.bias), test.describe(context.bias));
}

}  // namespace

Outcome check_reference(CheckContext& context, MaterialKind material, LightKind light) {
  if (!context.path_set.light_transport()) return {Verdict::not_claimed, "computes no light"};
  if (!context.claims(light)) return {Verdict::not_claimed, "does not claim this kind of light"};
  if (!context.claims(material)) return {Verdict::not_claimed, "does not claim this kind of material"};
  const std::pair scene(material, light);
  if (const auto known = context.compared.find(scene); known != context.compared.end()) return known->second;
  return context.compared[scene] = compare_with_reference(context, make_material_scene(material, light));
}

Outcome check_sky(CheckContext& context) {
  if (!context.path_set.light_transport()) return {Verdict::not_claimed, "computes no light"};
  if (!context.claims(LightKind::environment)) return {Verdict::not_claimed, "does not claim this kind of light"};
  const auto materials = claimed(context, {MaterialKind::mirror, MaterialKind::refraction});
  if (materials.empty()) return {Verdict::not_claimed, "claims neither mirrors nor glass"};
  return compare_with_reference(context, make_sky_scene(materials));
}

Outcome check_sides(CheckContext& context) {
  if (!context.path_set.light_transport()) return {Verdict::not_claimed, "computes no light"};
  if (!context.claims(LightKind::emissive)) return {Verdict::not_claimed, "does not claim this kind of light"};
  return compare_with_reference(context, make_sides_scene(claimed(context, {MaterialKind::mask, MaterialKind::blend})));
}

Outcome check_lobes(CheckContext& context) {
  if (!context.path_set.light_transport()) return {Verdict::not_claimed, "computes no light"};
  const auto lobes = claimed(context, {MaterialKind::diffuse, MaterialKind::mirror});
  if (lobes.size() < 2) return {Verdict::not_claimed, "does not claim both kinds of material"};
  return compare_with_reference(context, make_lobes_scene(context.any_light()));
}

}  // namespace lucarium::check
