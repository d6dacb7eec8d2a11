// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/technique_state.h"

#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/services/surface_atlas/most_texels.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

// A technique without a state is never asked: state_refusal() comes first.
void Technique::save_state(StateWriter&) { throw Error(ErrorClass::technique, "has no state to save"); }
void Technique::load_state(const StateReader&) { throw Error(ErrorClass::technique, "has no state to load"); }

StateWriter::~StateWriter() = default;
StateReader::~StateReader() = default;

void StateReader::fail(const std::string& name, const std::string& what) const {
  throw_error(ErrorClass::input, "{}: chunk '{}': {}; save the state again", source(), name, what);
}

uint64_t StateReader::checked_count(const std::string& name, size_t bytes) const {
  if (!has(name)) fail(name, "it is missing");
  if (element_bytes(name) != bytes)
    fail(name, fmt::format("its elements have {} bytes, not {}", element_bytes(name), bytes));
  return count(name);
}

void StateReader::require_count(const std::string& name, size_t bytes, uint64_t expected) const {
  const uint64_t elements = checked_count(name, bytes);
  if (elements != expected) fail(name, fmt::format("it has {} elements, not {}", elements, expected));
}

void StateReader::require_finite(const std::string& name, const float* values, size_t number) const {
  for (size_t i = 0; i < number; ++i)
    if (!std::isfinite(values[i])) fail(name, fmt::format("number {} of {} is not finite", i, number));
}

void StateReader::require_range(const std::string& name, const float* values, size_t number, double largest) const {
  for (size_t i = 0; i < number; ++i)
    if (!(values[i] >= 0) || double{values[i]} > largest)
      fail(name, fmt::format("number {} of {} is {:g}, not from 0 to {:g}", i, number, values[i], largest));
}

uint64_t saved_texels(const StateReader& state) {
  const auto texels = state.get_value<uint64_t>("texels");
  if (texels == 0 || texels > kMaxAtlasTexels) state.fail("texels", fmt::format("an atlas of {} texels", texels));
  return texels;
}

}  // namespace lucarium
