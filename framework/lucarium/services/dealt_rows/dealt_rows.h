// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/device/device.h"
#include "lucarium/compute/schedule/schedule.h"

namespace lucarium {

/// Makes `pass` take one of `rows` rows per work-item, dealt to the threads of a processor, so that each has as many
/// from wherever the work is. Sets the size and the argument `dealt_columns` of DEALT_ROW (dealt_rows.clh), which says
/// which row a work-item takes: as many columns as threads, a power of two, since threads share what rows side by side
/// read.
void deal_rows(PassBuilder& pass, size_t rows, const Device& device);

/// That argument, for passes whose size is set elsewhere.
uint32_t dealt_columns(const Device& device);

}  // namespace lucarium
