// SPDX-License-Identifier: Apache-2.0
// Checks of scenes that change. Declared in checks.h.
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/conformance/block_comparison.h"
#include "lucarium/conformance/check_scenes.h"
#include "lucarium/conformance/checks.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium::check {
namespace {

constexpr double camera_seconds = 0.1;  // allowed for a move of the camera
constexpr int moving = 1, soft = 2;     // instances of the changing scene

SceneChange move_camera(Scene& scene) {
  scene.cameras.front() = look_at_camera("side", {2.6f, 1.3f, 2.2f}, {0, 0.4f, 0}, 42.f);
  SceneChange change;
  change.camera = true;
  return change;
}

SceneChange move_box(Scene& scene) {
  SceneChange change;
  change.moved_instances = {moving};
  change.previous_world_from_object = {scene.instances[moving].world_from_object};
  scene.instances[moving].world_from_object =
      glm::rotate(glm::translate(glm::mat4(1.f), {0.1f, 0.2f, 0.4f}), 0.4f, glm::vec3(0, 1, 0));
  return change;
}

SceneChange bend_box(Scene& scene) {
  Mesh bent = *scene.instances[soft].pose;
  for (glm::vec3& p : bent.positions) p.x += 0.3f * p.y;
  scene.instances[soft].pose = std::make_shared<Mesh>(std::move(bent));
  SceneChange change;
  change.deformed_instances = {soft};
  return change;
}

SceneChange paint_box(Scene& scene) {
  const int material = scene.instances[moving].material;
  scene.materials[material].base_color = {0.1f, 0.8f, 0.3f, 1};
  SceneChange change;
  change.materials = {material};
  return change;
}

/// The box vanishes, as the scene's only surface that is not opaque, or comes back.
SceneChange set_mask(Scene& scene, bool on) {
  const int index = scene.instances[moving].material;
  SceneMaterial& material = scene.materials[index];
  material.alpha_mode = on ? AlphaMode::mask : AlphaMode::opaque;
  material.base_color.a = on ? 0.f : 1.f;
  SceneChange change;
  change.materials = {index};
  return change;
}

SceneChange dim_lights(Scene& scene) {
  SceneChange change;
  for (SceneLight& light : scene.lights) light.intensity *= glm::vec3(0.25f, 0.5f, 2.f);
  change.lights = !scene.lights.empty();
  if (scene.environment) {
    scene.environment->factor *= glm::vec3(0.25f, 0.5f, 2.f);
    change.environment = true;
  }
  return change;
}

SceneChange add_box(Scene& scene) {
  const int material = add_lambert(scene, "new", {0.8f, 0.8f, 0.2f});
  add_instance(scene, add_mesh(scene, MeshBuilder("new").box({-0.2f, 0.05f, 0.5f}, {0.2f, 0.5f, 0.9f}).take()),
               material);
  SceneChange change;
  change.topology = true;
  return change;
}

SceneChange apply(ChangeKind kind, Scene& scene) {
  switch (kind) {
    case ChangeKind::camera: return move_camera(scene);
    case ChangeKind::transforms: return move_box(scene);
    case ChangeKind::deformation: return bend_box(scene);
    case ChangeKind::materials: return paint_box(scene);
    case ChangeKind::lights: return dim_lights(scene);
    case ChangeKind::topology: return add_box(scene);
  }
  throw Error(ErrorClass::internal, "no change of this kind");
}

/// A light by which a change of `kind` is visible: not a surface where lights change.
LightKind light_for(const CheckContext& context, ChangeKind kind) {
  if (kind != ChangeKind::lights) return context.any_light();
  for (const LightKind light : {LightKind::point, LightKind::spot, LightKind::directional})
    if (context.claims(light)) return light;
  return LightKind::environment;
}

/// A view-independent technique keeps what it has gathered, so its picture is another sample of the same.
Outcome compare_samples(CheckContext& context, const Scene& before, const Scene& after, const SceneCamera& camera) {
  RenderSession moved = context.session(before), fresh = context.session(after);
  const BlockTest test = compare_seeds(
      [&](uint64_t seed) {
        moved.set_camera(before.cameras.front());
        moved.restart(seed);
        context.run_long(moved);
        moved.set_camera(camera);
        context.run_long(moved);
        return moved.resolve().image();
      },
      [&](uint64_t seed) {
        fresh.restart(seed + 100);
        context.run_long(fresh);
        return fresh.resolve().image();
      },
      context.bias);
  return verdict_of(test.passes(context.bias), "compared with a new run: " + test.describe(context.bias));
}

}  // namespace

Outcome check_camera_cost(CheckContext& context) {
  if (!context.claims(ChangeKind::camera)) return {Verdict::not_claimed, "does not support camera changes"};
  Scene scene = context.plain_scene();
  RenderSession session = context.session(scene);
  context.run_long(session);
  const double progress = session.last().progress;
  move_camera(scene);
  session.set_camera(scene.cameras.front());
  const RenderSession::Clocks clocks = session.clocks();
  const double seconds = clocks.upload + clocks.bvh + clocks.compile + clocks.prepare;
  std::string measured = fmt::format("{:.1f} ms, of which programs {:.1f} ms, hierarchy {:.1f} ms", 1e3 * seconds,
                                     1e3 * clocks.compile, 1e3 * clocks.bvh);
  bool good = seconds <= camera_seconds && clocks.compile == 0 && clocks.bvh == 0;
  if (context.can().view_independent && progress > 0) {
    const double after = session.iterate().progress;
    measured += fmt::format("; progress {:.2f} before, {:.2f} after", progress, after);
    good = good && after >= progress;
  }
  return verdict_of(good, measured);
}

Outcome check_change(CheckContext& context, ChangeKind kind) {
  if (!context.claims(kind)) return {Verdict::not_claimed, "does not support this change"};
  const LightKind light = light_for(context, kind);
  const Scene before = make_changing_scene(light);
  Scene after = before;
  apply(kind, after);
  if (kind == ChangeKind::camera && context.can().view_independent)
    return compare_samples(context, before, after, after.cameras.front());

  RenderSession changed = context.session(before), fresh = context.session(after);
  const Picture old = context.run_short(changed);
  changed.change_scene([&](Scene& scene) { return apply(kind, scene); });
  const Picture now = context.run_short(changed), expected = context.run_short(fresh);
  const std::string different = difference(now, expected);
  if (!different.empty()) return verdict_of(false, "differs from the image of a fresh start: " + different);
  return verdict_of(true, difference(old, now).empty() ? "same bits as a fresh start (and as before the change)"
                                                       : "same bits as a fresh start");
}

Outcome check_alpha_change(CheckContext& context) {
  if (!context.claims(ChangeKind::materials)) return {Verdict::not_claimed, "does not support material changes"};
  if (!context.claims(MaterialKind::mask)) return {Verdict::not_claimed, "does not support masks"};
  const Scene opaque = context.plain_scene();
  Scene masked = opaque;
  set_mask(masked, true);
  for (const bool on : {true, false}) {
    RenderSession changed = context.session(on ? opaque : masked), fresh = context.session(on ? masked : opaque);
    context.run_short(changed);
    changed.change_scene([on](Scene& scene) { return set_mask(scene, on); });
    const std::string different = difference(context.run_short(changed), context.run_short(fresh));
    if (!different.empty()) {
      return verdict_of(false, fmt::format("{} a mask: differs from the image of a fresh start: {}",
                                           on ? "with" : "without", different));
    }
  }
  return verdict_of(true, "same bits as a fresh start, with and without a mask");
}

}  // namespace lucarium::check
