// SPDX-License-Identifier: Apache-2.0
// How far the propagation of a field is, and what it has taken.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "virtual_light_field/field/light_field.h"

namespace lucarium::vlf {

LightField::Counts LightField::counts() const {
  Counts result = counts_;
  const auto cells = size_t{maps_.cells()};
  const size_t split = options_.split ? kSplitBytes : 0;
  result.rendering_bytes = maps_.index_bytes() + cells * (sizeof(uint32_t) + split);
  if (!subfields_) return result;
  result.subfields = subfields_->drawn();
  result.subfield_pixels = subfields_->drawn_pixels();
  result.kept_subfields = subfields_->kept_subfields();
  if (scatter_) result.cells_scattered = scatter_->cells_scattered();
  result.propagating_bytes = maps_.index_bytes() + cells * (kCellBytes + split) + subfields_->coarse_bytes() +
                             (scatter_ ? scatter_->norm_bytes() + maps_.list_bytes() : 0);
  return result;
}

double LightField::drawn_share() const {
  if (!subfields_ || stage_ == Stage::keep) return 1;
  return 1 - static_cast<double>(subfields_->kept_subfields()) / subfields_->subfields();
}

double LightField::progress() const {
  if (done()) return 1;
  if (!begun_ || stage_ == Stage::preview) return 0;
  if (options_.max_bounces >= 0) {
    // Stages are run through as often as there are sweeps, and once each to keep fragments and to survey.
    const double keeping = subfields_->keeps() ? 1 : 0, survey = tiled_ ? 1 : 0;
    const double before = stage_ == Stage::keep ? 0 : stage_ == Stage::survey ? keeping : keeping + survey + sweep_;
    const uint32_t subfields = subfields_of_stage();
    const double part = stage_ == Stage::scatter ? 1
                        : subfields > 0          ? static_cast<double>(next_subfield_) / subfields
                                                 : 0;
    return std::min((before + part) / (options_.max_bounces + 1 + keeping + survey), 0.99);
  }
  // The error falls by a factor per sweep: on a logarithmic scale it comes evenly.
  const double error = options_.tail ? tail_.error : tail_.without;
  if (sweep_ < 3 || !(error > 0) || !std::isfinite(error) || !(options_.residual > 0))
    return std::min(0.05 * sweep_, 0.2);
  return std::clamp(std::log(error) / std::log(options_.residual), 0.2, 0.99);
}

std::string LightField::phase() const {
  switch (stage_) {
    case Stage::preview: return "preview";
    case Stage::survey: return "survey";
    case Stage::keep: return "fragments";
    case Stage::transport: return fmt::format("sweep {}", sweep_);
    case Stage::scatter: return fmt::format("scatter {}", sweep_);
    case Stage::done: break;
  }
  return "walk";
}

}  // namespace lucarium::vlf
