// SPDX-License-Identifier: Apache-2.0
// A coarse field, displayed until a better one is known.
#include <algorithm>
#include <cmath>
#include <set>

#include "virtual_light_field/field/light_field.h"

namespace lucarium::vlf {
namespace {

constexpr uint32_t kCoarser = 4;         // in n: a sixteenth of the lines
constexpr uint32_t kPreviewBounces = 3;  // the fewest that show the ratio of the series

}  // namespace

/// The lines nearest to those of a coarser grid, which cover the sphere as evenly.
void LightField::choose_preview_lines() {
  preview_films_.clear();
  const uint32_t coarse_n = std::max(options_.dir_n / kCoarser, 2u);
  if (!options_.preview || !options_.sampled || options_.max_bounces == 0 || coarse_n == options_.dir_n) return;
  const DirectionGrid coarse(coarse_n, options_.seed);
  std::set<uint32_t> nearest;
  for (uint32_t line = 0; line < coarse.lines(); ++line) {
    const glm::dvec3 wanted = coarse.direction(2 * line);
    const auto cosine = [&](uint32_t l) { return std::abs(glm::dot(wanted, grid_.direction(2 * l))); };
    uint32_t best = 0;
    for (uint32_t l = 1; l < grid_.lines(); ++l)
      if (cosine(l) > cosine(best)) best = l;
    nearest.insert((best + 1) * options_.perturb - 1);  // the last film of the line ends it
  }
  preview_films_.assign(nearest.begin(), nearest.end());
}

/// Light of few bounces along few lines, with facets that scatter as much as they reflect, diffusely. Displayed until
/// as many sweeps of all lines have ended.
void LightField::end_preview_sweep() {
  fold_.set(fold_sweep_, preview_sweep_);
  scheduler_->run_to_end(fold_);
  const bool unlimited = options_.max_bounces < 0;
  if (++preview_sweep_ <= preview_bounces()) return;
  const FieldTail tail = find_tail(take_norms());
  show(unlimited && std::isfinite(tail.error) ? tail.factor : float4{}, false);
  ++shown_sweeps_;
  films_->forget_drawn();
  set_albedo(false);
  scheduler_->run_to_end(emit_);
  stage_ = stage_after_preview();
}

uint32_t LightField::preview_bounces() const {
  if (preview_films_.empty()) return 0;
  return options_.max_bounces < 0 ? kPreviewBounces
                                  : std::min(kPreviewBounces, static_cast<uint32_t>(options_.max_bounces));
}

}  // namespace lucarium::vlf
