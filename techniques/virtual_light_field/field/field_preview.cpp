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

uint32_t coarse_n(uint32_t dir_n) { return std::max(dir_n / kCoarser, 2u); }

uint32_t bounces_of(int max_bounces) {
  return max_bounces < 0 ? kPreviewBounces : std::min(kPreviewBounces, static_cast<uint32_t>(max_bounces));
}

bool has_preview(const LightField::Options& options) {
  return options.preview && options.sampled && options.max_bounces != 0 && coarse_n(options.dir_n) < options.dir_n;
}

}  // namespace

uint32_t LightField::estimate_preview_subfields(const Options& options) {
  const uint32_t n = coarse_n(options.dir_n);
  return has_preview(options) ? (2 * n * n + 1) * bounces_of(options.max_bounces) : 0;
}

/// The lines nearest to those of a coarser grid, which cover the sphere as evenly.
void LightField::choose_preview_lines() {
  preview_subfields_.clear();
  if (!has_preview(options_)) return;
  const DirectionGrid coarse(coarse_n(options_.dir_n), options_.seed);
  std::set<uint32_t> nearest;
  for (uint32_t line = 0; line < coarse.lines(); ++line) {
    const glm::dvec3 wanted = coarse.direction(2 * line);
    const auto cosine = [&](uint32_t l) { return std::abs(glm::dot(wanted, grid_.direction(2 * l))); };
    uint32_t best = 0;
    for (uint32_t l = 1; l < grid_.lines(); ++l)
      if (cosine(l) > cosine(best)) best = l;
    nearest.insert((best + 1) * options_.perturb - 1);  // the last subfield of the line ends it
  }
  preview_subfields_.assign(nearest.begin(), nearest.end());
}

/// Light of few bounces along few lines, with facets that scatter as much as they reflect, diffusely. Displayed until
/// as many sweeps of all lines have ended.
void LightField::end_preview_sweep() {
  fold_.set(fold_sweep_, preview_sweep_);
  scheduler_->run_to_end(fold_);
  const bool unlimited = options_.max_bounces < 0;
  if (++preview_sweep_ <= preview_bounces()) return;
  const FieldTail tail = find_tail(take_norms());
  const bool all = !unlimited && preview_bounces() == static_cast<uint32_t>(options_.max_bounces);
  show(unlimited && std::isfinite(tail.error) ? tail.factor : float4{}, all);
  ++shown_sweeps_;
  subfields_->forget_drawn();
  if (tiled_) set_albedo(false);
  scheduler_->run_to_end(emit_);
  stage_ = stage_after_preview();
}

uint32_t LightField::preview_bounces() const {
  return preview_subfields_.empty() ? 0 : bounces_of(options_.max_bounces);
}

}  // namespace lucarium::vlf
