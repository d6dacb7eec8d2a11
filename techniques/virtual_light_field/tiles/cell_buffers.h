// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/device/buffer.h"
#include "virtual_light_field/base/field_program.h"

namespace lucarium::vlf {

/// What each cell has, a uint: radiance is RGB9E5 times the field's scale, FIELD_NO_CELL where there is none.
struct CellBuffers {
  TypedBuffer<uint32_t> side;      ///< the texel side that it shows; LUCARIUM_NONE: none
  TypedBuffer<uint32_t> incoming;  ///< of the sweep that has ended: current
  TypedBuffer<uint32_t> sent;      ///< in this sweep: next
  TypedBuffer<uint32_t> total;     ///< sent in all of them
  TypedBuffer<uint32_t> direct;    ///< with split_layers: of it, what the first scattering sent

  /// split: split_layers. propagates: there will be more than what is displayed.
  CellBuffers(Device& device, size_t cells, bool split, bool propagates)
      : total(device, technique_name, "light of cells", cells, kRemedy),
        direct(device, technique_name, "direct light of cells", split ? cells : 0, kRemedy) {
    if (!propagates) return;
    side = TypedBuffer<uint32_t>(device, technique_name, "texel sides of cells", cells, kRemedy);
    incoming = TypedBuffer<uint32_t>(device, technique_name, "light received by cells", cells, kRemedy);
    sent = TypedBuffer<uint32_t>(device, technique_name, "light sent by cells", cells, kRemedy);
  }
  /// Only what is displayed stays.
  void end_propagation() { side = incoming = sent = {}; }

 private:
  static constexpr const char* kRemedy = "lower dir_n, cells or texels";
};

}  // namespace lucarium::vlf
