// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/compute/buffer.h"
#include "lucarium/compute/kernel_arguments.h"
#include "lucarium/compute/program.h"

namespace lucarium {

class ScheduleRecorder;
class Schedule;

/// A buffer as passes see it: real memory, or a transient whose memory the schedule provides.
class BufferRef {
 public:
  BufferRef() = default;
  BufferRef(const Buffer& buffer) : buffer_(buffer) {}  // NOLINT: implicit on purpose
  bool is_transient() const { return transient_ >= 0; }

 private:
  friend class ScheduleRecorder;
  friend class PassBuilder;
  friend class Schedule;
  Buffer buffer_;
  int transient_ = -1;  ///< index in the recorder
  const ScheduleRecorder* recorder_ = nullptr;
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
};

/// Describes one pass. Arguments are bound by name; compile() throws Error{device} for a missing, unknown or mistyped
/// one, naming kernel and argument and the nearest valid name.
class PassBuilder {
 public:
  PassBuilder& global(size_t x, size_t y = 1, size_t z = 1);
  /// Fixed local size; global sizes are rounded up to it (kernels check their index). Never left to the driver:
  /// PoCL compiles once per local size.
  PassBuilder& local(size_t x, size_t y = 1, size_t z = 1);
  /// Global x size read from a uint counter at run time: ceil(counter · items_per_count). The schedule reads the
  /// counter back before the pass (a declared wait).
  PassBuilder& global_by(BufferRef counter, size_t counter_index = 0, double items_per_count = 1.0);

  PassBuilder& arg(std::string_view name, const BufferRef& buffer);
  template <class T>
    requires(!std::is_base_of_v<Buffer, T> && !std::is_same_v<T, BufferRef>)
  PassBuilder& arg(std::string_view name, const T& value) {
    return value_argument(name, OpenClType<T>::name, &value, sizeof(T));
  }
  template <class T>
  PassBuilder& arg(std::string_view name, const Variable<T>& variable) {
    return variable_argument(name, OpenClType<T>::name, variable.index_);
  }
  PassBuilder& local_memory(std::string_view name, size_t bytes);

  /// The pass overwrites the whole buffer: it does not depend on what was there (cannot be derived from a signature).
  PassBuilder& discards(std::string_view argument);
  /// May be cut along x into slices of at most this many work-items (multiples of the local size), so that
  /// cancellation is felt. The kernel must take its base from an argument `uint slice_base`.
  PassBuilder& slice(size_t work_items);
  /// Bytes moved, for the profile's GB/s column.
  PassBuilder& moves_bytes(size_t bytes);

 private:
  friend class ScheduleRecorder;
  PassBuilder(ScheduleRecorder& recorder, int pass) : recorder_(&recorder), pass_(pass) {}
  PassBuilder& value_argument(std::string_view name, std::string_view type, const void* value, size_t bytes);
  PassBuilder& variable_argument(std::string_view name, std::string_view type, int variable);
  ScheduleRecorder* recorder_;
  int pass_;
};

struct RecordedSchedule;  // the recorder's data, internal

/// Collects passes, host steps and read-backs in program order. The order given here defines the meaning; the
/// schedule may run independent passes in any order or at once.
class ScheduleRecorder {
 public:
  ScheduleRecorder(Device& device, std::string name, std::string owner);
  ~ScheduleRecorder();
  ScheduleRecorder(ScheduleRecorder&&) noexcept;
  ScheduleRecorder& operator=(ScheduleRecorder&&) noexcept;

  Device& device() const;

  PassBuilder pass(std::string name, const Program& program, std::string_view kernel);

  /// Memory that exists only between its first and last use in one run; transients whose lives do not overlap share
  /// memory. Contents at first use are undefined.
  template <class T>
  BufferRef transient(std::string name, size_t count, const std::string& remedy = "") {
    return transient_bytes(std::move(name), sizeof(T), count, remedy);
  }
  /// A transient of `counter[index] · elements_per_count` elements, known only when the counter's writer has run
  /// (count → scan → fill). The schedule waits there, grows the memory to its high-water mark and goes on.
  template <class T>
  BufferRef transient_sized_by(std::string name, BufferRef counter, size_t index = 0, size_t elements_per_count = 1,
                               const std::string& remedy = "") {
    return transient_counted(std::move(name), sizeof(T), counter, index, elements_per_count, remedy);
  }

  template <class T>
  Variable<T> variable(std::string name, const T& initial) {
    Variable<T> result;
    result.index_ = add_variable(std::move(name), OpenClType<T>::name, &initial, sizeof(T));
    return result;
  }

  /// Host work between passes. It runs after the writers of `reads` and before readers of `writes`; it may use the
  /// buffers' blocking read/write.
  void host_step(std::string name, const std::vector<BufferRef>& reads, const std::vector<BufferRef>& writes,
                 std::function<void()> work);
  /// Copies a buffer to the host without stalling the device and hands it to `consume` when the run's fence has passed.
  void read_back(std::string name, const BufferRef& buffer, std::function<void(std::span<const std::byte>)> consume);
  void fill_zero(std::string name, const BufferRef& buffer);

  /// Checks every binding, derives dependencies, plans memory and creates one kernel object per pass. The recorder is
  /// empty afterwards.
  Schedule compile();

 private:
  friend class PassBuilder;
  BufferRef transient_bytes(std::string name, size_t element_bytes, size_t count, const std::string& remedy);
  BufferRef transient_counted(std::string name, size_t element_bytes, const BufferRef& counter, size_t index,
                              size_t elements_per_count, const std::string& remedy);
  int add_variable(std::string name, std::string_view type, const void* value, size_t bytes);
  std::unique_ptr<RecordedSchedule> recorded_;
};

enum class QueueMode { automatic, in_order, overlap };

/// An immutable recorded schedule; run() replays it.
class Schedule {
 public:
  Schedule();
  ~Schedule();
  Schedule(Schedule&&) noexcept;
  Schedule& operator=(Schedule&&) noexcept;
  explicit operator bool() const { return state_ != nullptr; }

  template <class T>
  void set(const Variable<T>& variable, const T& value) {
    set_variable(variable.index_, &value, sizeof(T));
  }

  const std::string& name() const;
  size_t pass_count() const;
  /// Bytes of transient memory as planned, and what they would take without sharing.
  size_t transient_bytes() const;
  size_t transient_bytes_unshared() const;
  /// Dependency edges (from, to) over pass indices after transitive reduction.
  std::vector<std::pair<int, int>> edges() const;
  std::string dot() const;  ///< Graphviz

  struct State;
  State& state() { return *state_; }

 private:
  friend class ScheduleRecorder;
  void set_variable(int index, const void* value, size_t bytes);
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
