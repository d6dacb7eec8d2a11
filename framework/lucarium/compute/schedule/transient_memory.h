// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/schedule/dependency_graph.h"
#include "lucarium/compute/schedule/transient_plan.h"

namespace lucarium {

struct TransientSpec {
  std::string name;
  size_t bytes = 0;      ///< unless counted
  bool counted = false;  ///< the size comes with resize()
  std::string remedy;
};

enum class TransientLayout {
  packed,  ///< sub-buffers of arenas, which overlap where their lives do not
  whole,   ///< one life at a time has an arena to itself: for drivers that crash with sub-buffers that overlap
  debug,   ///< nothing is shared; memory is poisoned where a life begins and lies between guard zones
};

/// Device memory for the lives of a schedule's transients. Lives of known size lie in arenas; counted ones use whole
/// buffers ("slots") that grow.
class TransientMemory {
 public:
  /// `specs` by transient. Throws Error{device} when the memory does not suffice.
  TransientMemory(Device& device, std::string schedule, std::string owner, std::vector<TransientSpec> specs,
                  std::vector<LiveRange> lives, TransientLayout layout);

  const std::vector<LiveRange>& lives() const { return lives_; }
  bool is_counted(int life) const { return spec(life).counted; }
  const std::string& name(int life) const { return spec(life).name; }
  bool debug() const { return layout_ == TransientLayout::debug; }

  /// The physical bytes of a life, for dependencies; `memory` numbers arenas and slots.
  MemoryAccess range(int life) const;
  int memory_count() const { return static_cast<int>(arenas_.size() + slots_.size()); }

  cl_mem handle(int life) const;  ///< null for a counted life before its first resize()
  size_t bytes(int life) const { return bytes_[static_cast<size_t>(life)]; }

  /// Gives a counted life room for `bytes`. Returns whether the handles of its slot changed; the device was idle then.
  bool resize(int life, size_t bytes);
  /// Whether two counted lives share a slot, so that a change of the one's handle is a change of the other's.
  bool same_slot(int a, int b) const;

  /// Debug mode: enqueues poison and guard zones; then throws Error{internal} with the life's name unless they are
  /// whole.
  void arm(int life);
  void check_guards(int life, const std::string& pass) const;

  size_t allocated_bytes() const;
  size_t unshared_bytes() const;

 private:
  struct Slot {
    Buffer buffer;
    ClMem inner;  ///< between the guard zones
    size_t capacity = 0;
  };

  const TransientSpec& spec(int life) const {
    return specs_[static_cast<size_t>(lives_[static_cast<size_t>(life)].transient)];
  }
  void allocate_arenas();
  Buffer allocate_slot(int life, size_t bytes, bool growing, size_t& capacity);
  ClMem sub_buffer(const Buffer& parent, size_t offset, size_t bytes) const;
  const Buffer& parent(int life) const;
  Placement place(int life) const { return places_[static_cast<size_t>(life)]; }

  Device* device_;
  std::string schedule_, owner_;
  std::vector<TransientSpec> specs_;
  std::vector<LiveRange> lives_;
  TransientLayout layout_;
  size_t guard_bytes_;
  std::vector<size_t> bytes_;      ///< by life
  std::vector<Placement> places_;  ///< by life; arena -1: counted
  std::vector<int> slot_of_;       ///< by life; -1: in an arena
  std::vector<Buffer> arenas_;
  std::vector<ClMem> sub_buffers_;  ///< by life; none where a life has an arena to itself
  std::vector<Slot> slots_;
};

}  // namespace lucarium
