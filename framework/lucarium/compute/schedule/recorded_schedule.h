// SPDX-License-Identifier: Apache-2.0
// What a ScheduleRecorder collects: internal to compute/, not installed as interface.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "lucarium/compute/program/program.h"
#include "lucarium/compute/schedule/schedule.h"

namespace lucarium {

enum class StepKind { kernel, fill_zero, read_back, host, counter_read };

struct RecordedArgument {
  enum class Kind { buffer, value, variable, local };
  std::string name;
  Kind kind = Kind::value;
  int index = -1;         ///< of the resource or variable
  std::string_view type;  ///< OpenCL type name of a value or variable
  size_t bytes = 0;       ///< of a value or of local memory
  size_t offset = 0;      ///< of a value in RecordedSchedule::values
};

struct RecordedStep {
  StepKind kind = StepKind::kernel;
  std::string name;

  Program program;  ///< keeps `signature` alive
  const KernelSignature* signature = nullptr;
  std::array<size_t, 3> global = {0, 0, 0}, local = {0, 0, 0};
  bool has_global = false, has_local = false;
  int counter = -1;  ///< of global_by(), index into RecordedSchedule::counters
  double items_per_count = 1;
  size_t slice_items = 0;
  size_t moved_bytes = 0;
  std::vector<RecordedArgument> arguments;
  std::vector<std::string> discards;

  std::vector<int> reads, writes;  ///< resources of all other kinds of steps
  std::function<void()> work;
  std::function<void(std::span<const std::byte>)> consume;
};

/// A caller's buffer, or a transient (null buffer).
struct RecordedResource {
  std::string name;
  Buffer buffer;
  size_t element_bytes = 0, count = 0;
  int counter = -1;  ///< sized by this counter: count is then elements per count
  std::string remedy;

  bool is_transient() const { return !buffer; }
  bool is_counted() const { return counter >= 0; }
  size_t bytes() const { return buffer ? buffer.bytes() : element_bytes * count; }  ///< unless is_counted()
};

/// One uint of a buffer that decides a size at run time.
struct RecordedCounter {
  int resource = -1;
  size_t index = 0;
};

struct RecordedVariable {
  std::string name;
  std::string_view type;
  std::vector<std::byte> value;
};

struct RecordedSchedule {
  uint64_t id = 0;  ///< distinguishes recordings, so that a BufferRef or Variable of another one is noticed
  std::shared_ptr<Device> device;
  std::string name, owner;
  bool debug_memory = false;
  std::vector<RecordedStep> steps;
  std::vector<RecordedResource> resources;
  std::vector<RecordedCounter> counters;
  std::vector<RecordedVariable> variables;
  std::vector<std::byte> values;
  std::unordered_map<cl_mem, int> resource_of_handle;

  int resource(const BufferRef& reference, std::string_view used_by);
  int counter(const BufferRef& reference, size_t index, std::string_view used_by);
};

}  // namespace lucarium
