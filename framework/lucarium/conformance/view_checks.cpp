// SPDX-License-Identifier: Apache-2.0
// Checks that light which does not depend on the camera stays what it is, in memory and in a file. Declared in
// checks.h.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/conformance/checks.h"
#include "lucarium/conformance/temporary_folder.h"
#include "lucarium/technique/state_file.h"

namespace lucarium::check {
namespace {

constexpr uint64_t samples = 3;

SceneCamera beside(SceneCamera camera) {
  camera.world_from_camera = glm::translate(glm::mat4(1.f), glm::vec3(0.05f, 0.03f, 0)) * camera.world_from_camera;
  return camera;
}

/// The picture of the first few samples from there, with the light as it is.
Picture seen_from(CheckContext& context, RenderSession& session, const SceneCamera& camera) {
  session.set_camera(camera);
  session.run({.samples = samples});
  return context.picture(session);
}

bool is_black(const Picture& picture) {
  return std::all_of(picture.begin(), picture.end(), [](const auto& layer) {
    return std::all_of(layer.second.begin(), layer.second.end(), [](float value) { return value == 0; });
  });
}

}  // namespace

Outcome check_view(CheckContext& context) {
  if (!context.can().view_independent) return {Verdict::not_claimed, "its data depend on the view"};
  const Scene scene = context.plain_scene();
  const SceneCamera camera = scene.cameras.front();
  RenderSession session = context.session(scene);
  Picture before = context.run_short(session);
  // While no light has come yet nothing is seen that could move.
  for (uint64_t lead = 0; lead < CheckContext::longest_lead && is_black(before) && !session.last().light_done; ++lead) {
    session.run({.iterations = 1});
    before = context.picture(session);
  }
  session.hold_light();
  const Picture first = seen_from(context, session, camera);
  if (!session.last().light_done) return verdict_of(false, "light_done is false behind hold_light()");
  const Picture elsewhere = seen_from(context, session, beside(camera));
  if (difference(first, elsewhere).empty()) return verdict_of(false, "the camera moves, and the picture does not");
  const std::string different = difference(first, seen_from(context, session, camera));
  return verdict_of(different.empty(), different.empty() ? "same bits, there and back" : different);
}

Outcome check_state(CheckContext& context) {
  const std::unique_ptr<Technique> technique = context.type.create();
  technique->parameters().set_all(context.options.parameters);
  if (const std::string reason = technique->state_refusal(); !reason.empty()) return {Verdict::not_claimed, reason};
  const Scene scene = context.plain_scene();
  const SceneCamera camera = scene.cameras.front();
  RenderSession session = context.session(scene);
  context.run_short(session);
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.state";
  session.save_state(file, true);
  session.hold_light();
  const Picture expected = seen_from(context, session, beside(camera));
  const StateFile state(file);
  RenderSession loaded(context.device, scene, context.type, context.settings(scene), context.options.parameters, {}, {},
                       &state);
  const std::string different = difference(expected, seen_from(context, loaded, beside(camera)));
  return verdict_of(different.empty(), different.empty() ? "same bits as before it was saved" : different);
}

}  // namespace lucarium::check
