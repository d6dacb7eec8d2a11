// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/transient_memory.h"

#include <algorithm>
#include <utility>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr size_t smallest_bytes = 64;    // OpenCL has no empty buffers
constexpr cl_uint poison = 0x7FC0DEADu;  // a NaN as float, far out of range as an index
constexpr cl_uchar guard_byte = 0xA5;

}  // namespace

TransientMemory::TransientMemory(Device& device, std::string schedule, std::string owner,
                                 std::vector<TransientSpec> specs, std::vector<LiveRange> lives, TransientLayout layout)
    : device_(&device),
      schedule_(std::move(schedule)),
      owner_(std::move(owner)),
      specs_(std::move(specs)),
      lives_(std::move(lives)),
      layout_(layout),
      guard_bytes_(debug() ? std::max<size_t>(1024, device.info().base_alignment_bytes) : 0),
      bytes_(lives_.size(), 0),
      places_(lives_.size()),
      slot_of_(lives_.size(), -1),
      sub_buffers_(lives_.size()) {
  std::vector<LiveRange> counted;
  std::vector<size_t> counted_index;
  for (size_t i = 0; i < lives_.size(); ++i) {
    if (!is_counted(static_cast<int>(i))) {
      bytes_[i] = spec(static_cast<int>(i)).bytes;
      continue;
    }
    counted.push_back(lives_[i]);
    counted_index.push_back(i);
  }
  const std::vector<int> slots = assign_slots(counted);
  int slot_count = 0;
  for (size_t i = 0; i < counted.size(); ++i) {
    slot_of_[counted_index[i]] = debug() ? static_cast<int>(i) : slots[i];
    slot_count = std::max(slot_count, slot_of_[counted_index[i]] + 1);
  }
  slots_.resize(static_cast<size_t>(slot_count));
  allocate_arenas();
}

void TransientMemory::allocate_arenas() {
  std::vector<LiveRange> fixed;
  std::vector<size_t> sizes, index;
  for (size_t i = 0; i < lives_.size(); ++i) {
    if (slot_of_[i] >= 0) continue;
    fixed.push_back(lives_[i]);
    sizes.push_back(std::max(bytes_[i], smallest_bytes));
    index.push_back(i);
  }
  ArenaPlan plan;
  if (debug()) {
    for (size_t i = 0; i < fixed.size(); ++i) {
      plan.placements.push_back({static_cast<int>(i), guard_bytes_});
      plan.arena_bytes.push_back(sizes[i] + 2 * guard_bytes_);
    }
  } else if (layout_ == TransientLayout::whole) {
    plan = place_lives_apart(fixed, sizes);
  } else {
    plan = place_lives(fixed, sizes, device_->info().base_alignment_bytes, device_->memory().single_bytes());
  }
  for (size_t arena = 0; arena < plan.arena_bytes.size(); ++arena) {
    size_t largest = 0;  // names the arena in messages
    for (size_t i = 0; i < fixed.size(); ++i) {
      if (static_cast<size_t>(plan.placements[i].arena) != arena) continue;
      if (static_cast<size_t>(plan.placements[largest].arena) != arena || sizes[i] > sizes[largest]) largest = i;
    }
    const TransientSpec& named = specs_[static_cast<size_t>(fixed[largest].transient)];
    arenas_.emplace_back(*device_, owner_, fmt::format("transients of '{}' (largest: '{}')", schedule_, named.name),
                         plan.arena_bytes[arena], named.remedy);
  }
  for (size_t i = 0; i < fixed.size(); ++i) {
    places_[index[i]] = plan.placements[i];
    const Buffer& arena = arenas_[static_cast<size_t>(plan.placements[i].arena)];
    if (layout_ != TransientLayout::whole)
      sub_buffers_[index[i]] = sub_buffer(arena, plan.placements[i].offset, sizes[i]);
  }
}

ClMem TransientMemory::sub_buffer(const Buffer& parent, size_t offset, size_t bytes) const {
  const cl_buffer_region region = {offset, bytes};
  cl_int code = CL_SUCCESS;
  ClMem part(clCreateSubBuffer(parent.handle(), 0, CL_BUFFER_CREATE_TYPE_REGION, &region, &code));
  check_opencl(code, "clCreateSubBuffer", parent.name(), *device_);
  return part;
}

MemoryAccess TransientMemory::range(int life) const {
  const int slot = slot_of_[static_cast<size_t>(life)];
  if (slot >= 0) return {static_cast<int>(arenas_.size()) + slot, 0, 1, false};
  const Placement at = place(life);
  return {at.arena, at.offset, at.offset + std::max(bytes(life), smallest_bytes), false};
}

cl_mem TransientMemory::handle(int life) const {
  const int slot = slot_of_[static_cast<size_t>(life)];
  if (slot < 0) {
    const ClMem& part = sub_buffers_[static_cast<size_t>(life)];
    return part ? part.get() : parent(life).handle();
  }
  const Slot& owner = slots_[static_cast<size_t>(slot)];
  if (owner.inner) return owner.inner.get();
  return owner.buffer ? owner.buffer.handle() : nullptr;
}

bool TransientMemory::same_slot(int a, int b) const {
  const int slot = slot_of_[static_cast<size_t>(a)];
  return slot >= 0 && slot == slot_of_[static_cast<size_t>(b)];
}

Buffer TransientMemory::allocate_slot(int life, size_t bytes, bool growing, size_t& capacity) {
  // A buffer that grew once may grow again: leave some room where the device has it.
  const size_t roomy = bytes + bytes / 4;
  const MemoryAccount& account = device_->memory();
  const bool fits =
      roomy + 2 * guard_bytes_ <= std::min(account.single_bytes(), account.total_bytes() - account.used_bytes());
  capacity = growing && fits ? roomy : bytes;
  return Buffer(*device_, owner_, fmt::format("transient '{}' of '{}'", name(life), schedule_),
                capacity + 2 * guard_bytes_, spec(life).remedy);
}

bool TransientMemory::resize(int life, size_t bytes) {
  Slot& slot = slots_[static_cast<size_t>(slot_of_[static_cast<size_t>(life)])];
  bytes_[static_cast<size_t>(life)] = bytes;
  const size_t needed = std::max(bytes, smallest_bytes);
  if (needed <= slot.capacity) return false;
  device_->finish();  // passes in flight may still use the old memory
  const bool growing = slot.capacity > 0;
  slot = Slot();
  slot.buffer = allocate_slot(life, needed, growing, slot.capacity);
  if (guard_bytes_ > 0) slot.inner = sub_buffer(slot.buffer, guard_bytes_, slot.capacity);
  return true;
}

const Buffer& TransientMemory::parent(int life) const {
  const int slot = slot_of_[static_cast<size_t>(life)];
  return slot >= 0 ? slots_[static_cast<size_t>(slot)].buffer : arenas_[static_cast<size_t>(place(life).arena)];
}

void TransientMemory::arm(int life) {
  const Buffer& memory = parent(life);
  const size_t end = guard_bytes_ + bytes(life), poisoned = bytes(life) / sizeof(poison) * sizeof(poison);
  const auto fill = [&](const void* pattern, size_t pattern_bytes, size_t offset, size_t size) {
    if (size == 0) return;
    check_opencl(clEnqueueFillBuffer(device_->queue(), memory.handle(), pattern, pattern_bytes, offset, size, 0,
                                     nullptr, nullptr),
                 "clEnqueueFillBuffer", memory.name(), *device_);
  };
  fill(&guard_byte, 1, 0, guard_bytes_);
  fill(&poison, sizeof(poison), guard_bytes_, poisoned);
  fill(&guard_byte, 1, end, memory.bytes() - end);
}

void TransientMemory::check_guards(int life, const std::string& pass) const {
  const Buffer& memory = parent(life);
  const size_t end = guard_bytes_ + bytes(life);
  const auto damaged = [&](size_t offset, size_t size) {
    std::vector<cl_uchar> zone(size);
    memory.read(zone.data(), size, offset);
    return std::any_of(zone.begin(), zone.end(), [](cl_uchar byte) { return byte != guard_byte; });
  };
  const bool before = damaged(0, guard_bytes_);
  if (!before && !damaged(end, memory.bytes() - end)) return;
  throw_error(ErrorClass::internal, "schedule '{}': pass '{}' wrote outside of transient '{}' ({} its {} bytes)",
              schedule_, pass, name(life), before ? "before" : "behind", bytes(life));
}

size_t TransientMemory::allocated_bytes() const {
  size_t sum = 0;
  for (const Buffer& arena : arenas_) sum += arena.bytes();
  for (const Slot& slot : slots_) sum += slot.buffer ? slot.buffer.bytes() : 0;
  return sum;
}

size_t TransientMemory::unshared_bytes() const {
  size_t sum = 0;
  std::vector<size_t> largest(specs_.size(), 0);
  for (size_t i = 0; i < lives_.size(); ++i) {
    size_t& bytes = largest[static_cast<size_t>(lives_[i].transient)];
    bytes = std::max(bytes, bytes_[i]);
  }
  for (const size_t bytes : largest) sum += bytes;
  return sum;
}

}  // namespace lucarium
