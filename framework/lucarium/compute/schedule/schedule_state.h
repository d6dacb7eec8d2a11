// SPDX-License-Identifier: Apache-2.0
// A compiled schedule: internal to compute/, shared by its compiler and its executor.
#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/schedule/recorded_schedule.h"
#include "lucarium/compute/schedule/transient_memory.h"

namespace lucarium {

/// Memory as a step sees it: a caller's buffer, or one life of a transient.
struct MemoryRef {
  int resource = -1;
  int life = -1;  ///< -1: a caller's buffer
};

struct BoundBuffer {
  cl_uint position = 0;  ///< of the kernel argument
  MemoryRef memory;
};

struct CompiledStep {
  StepKind kind = StepKind::kernel;
  std::string name;
  std::vector<int> begins;   ///< lives that begin here
  std::vector<int> lives;    ///< all lives it touches
  std::vector<int> written;  ///< callers' buffers it writes, as resources

  // Kernels. Each step owns its kernel object, since argument values live in it.
  ClKernel kernel;
  Program program;  ///< lives as long: of launch code that is made later, the cache hears from programs that live
  std::string kernel_name;
  std::string launch;            ///< program, kernel and work-group size, for CompileProgress
  bool has_launch_code = false;  ///< no other process compiles it any more
  std::array<size_t, 3> global = {0, 1, 1}, local = {1, 1, 1};
  int counter = -1;  ///< counter value that decides global[0], or that a counter read fetches
  double items_per_count = 1;
  size_t slice_items = 0;  ///< 0: in one piece
  int slice_base_position = -1;
  cl_uint slice_base = 0;  ///< as set in the kernel object
  std::vector<BoundBuffer> buffers;
  size_t moved_bytes = 0;

  // Fills, read-backs and counter reads.
  MemoryRef target;
  std::vector<std::byte> staging;
  std::function<void(std::span<const std::byte>)> consume;

  std::function<void()> work;  // host steps
};

/// One version of a counter: read once, used by every step that is sized by it.
struct CounterValue {
  MemoryRef memory;
  size_t index = 0;
  cl_uint value = 0;
};

struct VariableValue {
  std::string name;
  std::vector<std::byte> value;
  std::vector<std::pair<size_t, cl_uint>> uses;  ///< step, argument position
  bool changed = false;
};

/// Results of runs about their schedule; runs may outlive it.
struct ScheduleFacts {
  std::string name;                ///< "schedule 'a'"
  std::vector<std::string> where;  ///< by step, for messages
  std::vector<double> seconds;     ///< by step, in the last run that was measured; negative: never
  std::string failure;             ///< not empty: refuse to run
};

struct Schedule::State {
  ~State();

  uint64_t id = 0;  ///< of the recording
  std::shared_ptr<Device> device;
  std::string name, owner;
  std::vector<RecordedResource> resources;
  std::vector<CompiledStep> steps;
  std::vector<CounterValue> counters;
  std::vector<VariableValue> variables;
  std::optional<TransientMemory> memory;
  std::vector<int> counter_of_life;       ///< counter value by life; -1: its size is fixed
  std::vector<std::string> memory_names;  ///< of Dependency::memory, for the DOT graph
  DependencyGraph graph;
  std::vector<int> last_steps;  ///< steps that no other one waits for
  bool overlap_pays = false;    ///< some narrow pass has an independent partner
  bool has_read_back = false;

  // Across runs.
  bool in_flight = false;  ///< something may have been enqueued since the device was last idle
  std::shared_ptr<ScheduleFacts> facts;
  std::shared_ptr<std::vector<int>> profile_slots;  ///< by step, index in the profile `profile_id`
  uint64_t profile_id = 0;
  /// Copies that stand for the callers' buffers during a warm-up, by resource.
  std::vector<Buffer> scratch_copies;

  cl_mem handle(const MemoryRef& memory_of) const;
  size_t bytes(const MemoryRef& memory_of) const;
  /// "schedule 'a': pass 'b' (kernel 'c')".
  std::string where(const CompiledStep& step) const;
};

}  // namespace lucarium
