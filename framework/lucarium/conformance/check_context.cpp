// SPDX-License-Identifier: Apache-2.0
#include "lucarium/conformance/check_context.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lucarium/conformance/check_scenes.h"

namespace lucarium::check {
namespace {

template <class Kind>
bool holds(const std::vector<Kind>& list, Kind kind) {
  return std::find(list.begin(), list.end(), kind) != list.end();
}

}  // namespace

Picture picture_of(const Film& film) {
  Picture picture;
  for (const FilmLayer& layer : film.layers()) picture[layer.name] = layer.pixels;
  return picture;
}

std::string difference(const Picture& a, const Picture& b) {
  if (a.size() != b.size()) return fmt::format("{} layers against {}", a.size(), b.size());
  for (const auto& [name, mine] : a) {
    const auto other = b.find(name);
    if (other == b.end()) return fmt::format("layer {} is missing", name);
    const std::vector<float>& theirs = other->second;
    if (mine.size() != theirs.size())
      return fmt::format("layer {}: {} values against {}", name, mine.size(), theirs.size());
    size_t differing = 0;
    double largest = 0;
    for (size_t i = 0; i < mine.size(); ++i) {
      if (std::memcmp(&mine[i], &theirs[i], sizeof(float)) == 0) continue;
      ++differing;
      largest = std::max(largest, std::abs(double{mine[i]} - double{theirs[i]}));
    }
    if (differing > 0)
      return fmt::format("layer {}: {} of {} values differ, by up to {:.2g}", name, differing, mine.size(), largest);
  }
  return "";
}

bool CheckContext::claims(LightKind kind) const { return holds(can().lights, kind); }
bool CheckContext::claims(MaterialKind kind) const { return holds(can().materials, kind); }
bool CheckContext::claims(ChangeKind kind) const { return holds(can().changes, kind); }

LightKind CheckContext::any_light() const {
  using enum LightKind;
  for (const LightKind kind : {emissive, environment, point, spot, directional})
    if (claims(kind)) return kind;
  return environment;
}

RenderSettings CheckContext::settings(const Scene& scene) const {
  RenderSettings settings;
  settings.width = settings.height = picture_side;
  settings.max_bounces = can().max_bounces < 0 ? 3 : std::min(3, can().max_bounces);
  if (!holds_sampling(0)) settings.pixel_sampling = can().pixel_sampling.empty() ? 0 : can().pixel_sampling.front();
  settings.camera = scene.cameras.front();
  return settings;
}

bool CheckContext::holds_sampling(uint32_t mode) const {
  return std::find(can().pixel_sampling.begin(), can().pixel_sampling.end(), mode) != can().pixel_sampling.end();
}

RenderSession CheckContext::session(const Scene& scene, const RenderSettings& settings) const {
  return RenderSession(device, scene, type, settings, options.parameters);
}

RenderSession CheckContext::session(const Scene& scene) const { return session(scene, settings(scene)); }

Scene CheckContext::plain_scene() const { return make_changing_scene(any_light()); }

void CheckContext::run_long(RenderSession& session) const {
  const RenderBudget budget{.iterations = 64, .samples = 64};
  bool interrupted = session.run(budget);
  // Where no sample counts before all light is there, that may take longer: as long as its progress grows.
  double before = 0;
  while (!interrupted && session.last().samples == 0 && session.last().progress > before) {
    before = session.last().progress;
    interrupted = session.run(budget);
  }
}

Picture CheckContext::run_short(RenderSession& session, uint64_t iterations) const {
  // What a technique does before it begins to render (its progress is known, and 0) comes first, or it alone would be
  // seen.
  const auto leads = [&] {
    return session.last().progress == 0 && !session.last().phase.empty() && !session.last().converged;
  };
  session.run({.iterations = 1});
  for (uint64_t lead = 0; lead < longest_lead && leads(); ++lead) session.run({.iterations = 1});
  if (iterations > 1) session.run({.iterations = iterations - 1});
  return picture(session);
}

}  // namespace lucarium::check
