// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/dealt_rows/dealt_rows.h"

#include <algorithm>
#include <bit>

namespace lucarium {

namespace {

constexpr uint32_t max_columns = 16;

}  // namespace

uint32_t dealt_columns(const Device& device) {
  if (device.info().type != DeviceType::cpu) return 1;
  return std::min(max_columns, std::bit_ceil(std::max(1u, device.info().compute_units)));
}

void deal_rows(PassBuilder& pass, size_t rows, const Device& device) {
  pass.global(rows).local(1).arg("dealt_columns", dealt_columns(device));
}

}  // namespace lucarium
