// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/compute/program/program.h"
#include "lucarium/shared/opencl_type.h"

namespace lucarium {

class ScheduleRecorder;
class Schedule;
struct RecordedSchedule;  // the recorder's data, internal

/// A buffer as passes see it: real memory, or a transient whose memory the schedule provides.
class BufferRef {
 public:
  BufferRef() = default;
  BufferRef(const Buffer& buffer) : buffer_(buffer) {}  // NOLINT: implicit on purpose
  bool is_transient() const { return transient_ >= 0; }

 private:
  friend class ScheduleRecorder;
  friend struct RecordedSchedule;
  Buffer buffer_;
  int transient_ = -1;      ///< resource of the recording
  uint64_t recording_ = 0;  ///< whose transient it is
};

/// A by-value argument that may change between runs of a recorded schedule; several passes may use it.
template <class T>
class Variable {
 public:
  Variable() = default;

 private:
  friend class ScheduleRecorder;
  friend class PassBuilder;
  friend class Schedule;
  int index_ = -1;
  uint64_t recording_ = 0;
};

/// Describes one pass. Arguments are bound by name; compile() throws Error{device} for a missing, unknown or mistyped
/// one, naming kernel and argument and the nearest valid name.
class PassBuilder {
 public:
  PassBuilder& global(size_t x, size_t y = 1, size_t z = 1);
  /// Fixed local size; global sizes are rounded up to it (kernels check their index). Never left to the driver, since
  /// PoCL compiles once per local size: without this call it is what the kernel requires, else 64 (at most the
  /// device's limit).
  PassBuilder& local(size_t x, size_t y = 1, size_t z = 1);
  /// Global x size read from a uint counter at run time: ceil(counter · items_per_count); with 0 the pass is left
  /// out. The schedule reads the counter back before the pass (a declared wait; passes that use the same value share
  /// it). y and z are those of global(), else 1.
  PassBuilder& global_by(const BufferRef& counter, size_t counter_index = 0, double items_per_count = 1.0);

  PassBuilder& arg(std::string_view name, const BufferRef& buffer);
  template <class T>
  requires(!std::is_base_of_v<Buffer, T> && !std::is_same_v<T, BufferRef>) PassBuilder& arg(std::string_view name,
                                                                                            const T& value) {
    return value_argument(name, OpenClType<T>::name, &value, sizeof(T));
  }
  template <class T>
  PassBuilder& arg(std::string_view name, const Variable<T>& variable) {
    return variable_argument(name, OpenClType<T>::name, variable.index_, variable.recording_);
  }
  /// Binds a buffer if the kernel has an argument of that name, else does nothing: for lists of buffers of which a
  /// kernel names what it needs.
  PassBuilder& arg_if_present(std::string_view name, const BufferRef& buffer);
  template <class T>
  requires(!std::is_base_of_v<Buffer, T> &&
           !std::is_same_v<T, BufferRef>) PassBuilder& arg_if_present(std::string_view name, const T& value) {
    return has_argument(name) ? arg(name, value) : *this;
  }
  /// Whether the kernel has an argument of this name.
  bool has_argument(std::string_view name) const;
  /// Size of a `__local` pointer argument.
  PassBuilder& local_memory(std::string_view name, size_t bytes);

  /// The pass overwrites the whole buffer: it does not depend on its contents (cannot be derived from a signature).
  /// A transient may then lie elsewhere than before.
  PassBuilder& discards(std::string_view argument);
  /// May be cut along x into slices of at most this many work-items (multiples of the local size), so that
  /// cancellation is felt. The kernel must add its argument `uint slice_base`, which the schedule binds, to
  /// get_global_id(0). At most 2^32 work-items along x: with more, the run throws Error{device}.
  PassBuilder& slice(size_t work_items);
  /// Bytes moved, for the profile's GB/s column.
  PassBuilder& moves_bytes(size_t bytes);

 private:
  friend class ScheduleRecorder;
  PassBuilder(RecordedSchedule& recorded, size_t step) : recorded_(&recorded), step_(step) {}
  PassBuilder& value_argument(std::string_view name, std::string_view type, const void* value, size_t bytes);
  PassBuilder& variable_argument(std::string_view name, std::string_view type, int variable, uint64_t recording);
  RecordedSchedule* recorded_;
  size_t step_;
};

/// Collects passes, host steps and read-backs in program order. The order given here defines the meaning; the
/// schedule may run independent passes in any order or at once.
class ScheduleRecorder {
 public:
  /// `owner` pays for the transients in the memory account. `debug_memory` as in SchedulerOptions.
  ScheduleRecorder(Device& device, std::string name, std::string owner, bool debug_memory = false);
  ~ScheduleRecorder();
  ScheduleRecorder(ScheduleRecorder&&) noexcept;
  ScheduleRecorder& operator=(ScheduleRecorder&&) noexcept;

  Device& device() const;

  /// Throws Error{device} with the nearest name when the program has no such kernel.
  PassBuilder pass(std::string name, const Program& program, std::string_view kernel);

  /// Memory that exists only between its first and last use in one run; transients whose lives do not overlap share
  /// memory. Contents at first use are undefined; compile() refuses one that is read and never written before.
  template <class T>
  BufferRef transient(std::string name, size_t count, const std::string& remedy = "") {
    return transient_bytes(std::move(name), sizeof(T), count, remedy);
  }
  /// A transient of `counter[index] · elements_per_count` elements, known only when the counter's writer has run
  /// (count → scan → fill). Before its first use the schedule waits for the counter's writer, reads it, grows the
  /// memory to its high-water mark and goes on. The size holds for the rest of the run. If it does not fit into the
  /// device's memory, the run fails with the numbers and `remedy`; nothing is dropped.
  template <class T>
  BufferRef transient_sized_by(std::string name, const BufferRef& counter, size_t index = 0,
                               size_t elements_per_count = 1, const std::string& remedy = "") {
    return transient_counted(std::move(name), sizeof(T), counter, index, elements_per_count, remedy);
  }

  template <class T>
  Variable<T> variable(const std::string& name, const T& initial) {
    Variable<T> result;
    result.index_ = add_variable(name, OpenClType<T>::name, &initial, sizeof(T), result.recording_);
    return result;
  }

  /// Host work between passes. It runs after the writers of `reads` and of `writes`, after the readers of `writes`,
  /// and before later users of `writes`; it may use the buffers' blocking read/write, and nothing else of the device.
  void host_step(std::string name, const std::vector<BufferRef>& reads, const std::vector<BufferRef>& writes,
                 std::function<void()> work);
  /// Copies a buffer to the host without stalling the device and hands it to `consume` when the whole run has ended.
  void read_back(std::string name, const BufferRef& buffer, std::function<void(std::span<const std::byte>)> consume);
  void fill_zero(std::string name, const BufferRef& buffer);

  /// Checks every binding, derives dependencies, plans memory and creates one kernel object per pass. The recorder is
  /// empty afterwards.
  Schedule compile();

 private:
  BufferRef transient_bytes(std::string name, size_t element_bytes, size_t count, const std::string& remedy);
  BufferRef transient_counted(std::string name, size_t element_bytes, const BufferRef& counter, size_t index,
                              size_t elements_per_count, const std::string& remedy);
  int add_variable(std::string name, std::string_view type, const void* value, size_t bytes, uint64_t& recording);
  std::unique_ptr<RecordedSchedule> recorded_;
};

/// How passes are enqueued. `overlap` uses an out-of-order queue, so that independent passes run at once;
/// `automatic` does so where some pass with few work-groups has an independent partner. Results are the same.
enum class QueueMode { automatic, in_order, overlap };

/// An immutable recorded schedule; KernelScheduler::run() replays it. Its steps are the passes, fills, read-backs and
/// host steps as recorded, and the counter reads that global_by() and transient_sized_by() need, each just before its
/// first use. Destroying it waits for the device when a run may still be in flight.
class Schedule {
 public:
  Schedule();
  ~Schedule();
  Schedule(Schedule&&) noexcept;
  Schedule& operator=(Schedule&&) noexcept;
  explicit operator bool() const { return state_ != nullptr; }

  template <class T>
  void set(const Variable<T>& variable, const std::type_identity_t<T>& value) {
    set_variable(variable.index_, variable.recording_, &value, sizeof(T));
  }

  const std::string& name() const;
  /// All steps, counter reads included.
  size_t pass_count() const;
  const std::string& pass_name(size_t step) const;
  /// Bytes of transient memory at present, and what they would take without sharing.
  size_t transient_bytes() const;
  size_t transient_bytes_unshared() const;
  /// Dependency edges (from, to) over step indices after transitive reduction.
  std::vector<std::pair<int, int>> edges() const;
  std::string dot() const;  ///< Graphviz

  struct State;
  State& state() { return *state_; }

 private:
  friend class ScheduleRecorder;
  void set_variable(int index, uint64_t recording, const void* value, size_t bytes);
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
