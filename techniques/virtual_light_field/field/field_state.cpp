// SPDX-License-Identifier: Apache-2.0
// What is saved of a field, chunk by chunk.
#include <fmt/format.h>

#include <cmath>

#include "virtual_light_field/field/light_field.h"

namespace lucarium::vlf {
namespace {

struct SavedField {
  float scale;
  uint32_t shown_sweeps, sweeps, cells;
};

}  // namespace

void LightField::save(StateWriter& chunks) const {
  scheduler_->finish();
  chunks.put_value("field", SavedField{scale_, shown_sweeps_, sweep_, maps_.cells()});
  chunks.put("why_done", std::vector<char>(why_done_.begin(), why_done_.end()));
  chunks.put("sides.direct", shown_direct_);
  chunks.put("sides.indirect", shown_);
  chunks.put("sides.held", held_);
  if (halves_.two()) chunks.put("sides.covered", halves_.covered);
  if (!tiled_) return;
  chunks.put("cells.total", cells_.total);
  if (options_.split) chunks.put("cells.direct", cells_.direct);
}

void LightField::load(const StateReader& chunks) {
  const auto saved = chunks.get_value<SavedField>("field");
  if (saved.cells != maps_.cells())
    chunks.fail("field", fmt::format("{} cells, and the scene has {}", saved.cells, maps_.cells()));
  int exponent = 0;
  if (!(saved.scale >= 1 / kMaxScale && saved.scale <= kMaxScale) || std::frexp(saved.scale, &exponent) != 0.5f)
    chunks.fail("field", fmt::format("the scale {}", saved.scale));
  if (saved.shown_sweeps == 0) chunks.fail("field", "no sweep that is shown");
  // No sweep brings more than the brightest sender has, kMaxStored over the scale, nor the tail more than 999 of them;
  // sixteen times as much is no light of this scene. What a side counts stands beside its light: 1 at most.
  const double largest =
      std::max(1.0, 16 * (static_cast<double>(saved.sweeps) + 1000) * double{kMaxStored} / double{saved.scale});
  chunks.get_light_buffer("sides.direct", shown_direct_, largest);
  chunks.get_light_buffer("sides.indirect", shown_, largest);
  chunks.get_light_buffer("sides.held", held_, largest);
  if (halves_.two()) chunks.get_buffer("sides.covered", halves_.covered);
  if (tiled_) {
    chunks.get_buffer("cells.total", cells_.total);
    if (options_.split) chunks.get_buffer("cells.direct", cells_.direct);
  }
  const std::vector<char> why = chunks.get<char>("why_done");
  why_done_.assign(why.begin(), why.end());
  scale_ = saved.scale;
  shown_sweeps_ = saved.shown_sweeps;
  sweep_ = saved.sweeps;
  begun_ = true;
}

}  // namespace lucarium::vlf
