// SPDX-License-Identifier: Apache-2.0
// From a recording to a Schedule: bind, insert counter reads, plan transients, derive dependencies, create kernels.
// Declared in schedule.h.
#include <algorithm>
#include <map>
#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/compute/schedule/bind_arguments.h"
#include "lucarium/compute/schedule/launch_code.h"
#include "lucarium/compute/schedule/schedule_state.h"

namespace lucarium {
namespace {

/// A step while it is being compiled.
struct Draft {
  RecordedStep* recorded = nullptr;  ///< null: a counter read
  std::string name;
  int reads_counter = -1;           ///< counter value that this step fetches
  std::vector<int> needs_counters;  ///< counter values that must be known before it
  int global_counter = -1;          ///< the one of them that decides the global size
  std::vector<BufferAccess> accesses;
  BoundArguments bound;
};

class ScheduleCompiler {
 public:
  explicit ScheduleCompiler(RecordedSchedule& recorded)
      : recorded_(recorded), state_(std::make_unique<Schedule::State>()) {
    state_->id = recorded.id;
    state_->device = recorded.device;
    state_->name = recorded.name;
    state_->owner = recorded.owner;
  }

  std::unique_ptr<Schedule::State> compile() {
    draft_steps();
    plan_transients();
    derive_graph();
    for (size_t i = 0; i < drafts_.size(); ++i) state_->steps.push_back(finish_step(i));
    set_kernel_arguments();
    decide_overlap();
    state_->resources = std::move(recorded_.resources);
    state_->facts = std::make_shared<ScheduleFacts>();
    state_->facts->name = fmt::format("schedule '{}'", recorded_.name);
    state_->facts->seconds.assign(drafts_.size(), -1.0);
    for (const Step& step : state_->steps) state_->facts->where.push_back(state_->where(step));
    return std::move(state_);
  }

 private:
  using Step = CompiledStep;

  std::string where(const RecordedStep& step) const {
    if (step.kind != StepKind::kernel) return fmt::format("schedule '{}': step '{}'", recorded_.name, step.name);
    return fmt::format("schedule '{}': pass '{}' (kernel '{}')", recorded_.name, step.name, step.signature->name);
  }
  const RecordedResource& resource(int index) const { return recorded_.resources[static_cast<size_t>(index)]; }
  Device& device() const { return *recorded_.device; }

  void draft_steps();
  Draft draft(RecordedStep& step) const;
  int counter_value(int counter);
  void plan_transients();
  void derive_graph();
  void name_memories();
  Step finish_step(size_t index);
  void finish_kernel(const Draft& draft, Step& step);
  void choose_sizes(const RecordedStep& recorded, Step& step) const;
  void check_local_memory(const RecordedStep& recorded, const Step& step) const;
  void set_kernel_arguments();
  void decide_overlap();
  MemoryRef memory_ref(int resource_index, size_t step) const;
  int life_at(int transient, size_t step) const;

  RecordedSchedule& recorded_;
  std::unique_ptr<Schedule::State> state_;
  std::vector<Draft> drafts_;
  std::vector<uint64_t> versions_;                  ///< writes so far, by resource
  std::map<std::pair<int, uint64_t>, int> values_;  ///< (counter, version) → counter value
  std::vector<int> counter_of_value_;               ///< recorded counter by value
  std::vector<int> value_of_transient_;             ///< counter value by resource; -1: fixed size
  std::vector<std::vector<int>> lives_of_;          ///< by resource
};

Draft ScheduleCompiler::draft(RecordedStep& step) const {
  Draft result;
  result.recorded = &step;
  result.name = step.name;
  if (step.kind == StepKind::kernel) {
    result.bound = bind_arguments(where(step), step, recorded_.resources);
    result.accesses = result.bound.accesses;
    return result;
  }
  const bool discards = step.kind == StepKind::fill_zero;
  for (const int written : step.writes) result.accesses.push_back({written, true, discards});
  for (const int read : step.reads) {
    const bool known = std::any_of(result.accesses.begin(), result.accesses.end(),
                                   [&](const BufferAccess& access) { return access.resource == read; });
    if (!known) result.accesses.push_back({read, false, false});
  }
  return result;
}

/// The present value of a counter; plans a read when it is needed for the first time.
int ScheduleCompiler::counter_value(int counter) {
  const RecordedCounter& recorded = recorded_.counters[static_cast<size_t>(counter)];
  const auto key = std::pair(counter, versions_[static_cast<size_t>(recorded.resource)]);
  const auto [found, fresh] = values_.try_emplace(key, static_cast<int>(counter_of_value_.size()));
  if (fresh) {
    counter_of_value_.push_back(counter);
    Draft read;
    read.name = fmt::format("read {}[{}]", resource(recorded.resource).name, recorded.index);
    read.reads_counter = found->second;
    read.accesses.push_back({recorded.resource, false, false});
    const int sized_by = value_of_transient_[static_cast<size_t>(recorded.resource)];
    if (sized_by >= 0) read.needs_counters.push_back(sized_by);
    drafts_.push_back(std::move(read));
  }
  return found->second;
}

void ScheduleCompiler::draft_steps() {
  versions_.assign(recorded_.resources.size(), 0);
  value_of_transient_.assign(recorded_.resources.size(), -1);
  for (RecordedStep& step : recorded_.steps) {
    Draft next = draft(step);
    if (step.counter >= 0) {
      next.global_counter = counter_value(step.counter);
      next.needs_counters.push_back(next.global_counter);
    }
    for (const BufferAccess& access : next.accesses) {
      int& value = value_of_transient_[static_cast<size_t>(access.resource)];
      if (resource(access.resource).is_counted() && value < 0) value = counter_value(resource(access.resource).counter);
      if (value >= 0) next.needs_counters.push_back(value);
    }
    for (const BufferAccess& access : next.accesses) versions_[static_cast<size_t>(access.resource)] += access.writes;
    drafts_.push_back(std::move(next));
  }
}

void ScheduleCompiler::plan_transients() {
  std::vector<TransientUse> uses;
  std::vector<bool> single_life;
  std::vector<TransientSpec> specs;
  for (const RecordedResource& each : recorded_.resources) {
    single_life.push_back(each.is_counted());
    specs.push_back({each.name, each.is_counted() ? 0 : each.bytes(), each.is_counted(), each.remedy});
  }
  for (size_t i = 0; i < drafts_.size(); ++i) {
    for (const BufferAccess& access : drafts_[i].accesses) {
      if (resource(access.resource).is_transient())
        uses.push_back({static_cast<int>(i), access.resource, access.discards});
    }
  }
  std::vector<LiveRange> lives = compute_live_ranges(uses, single_life);
  lives_of_.resize(recorded_.resources.size());
  for (size_t i = 0; i < lives.size(); ++i) {
    const LiveRange& life = lives[i];
    lives_of_[static_cast<size_t>(life.transient)].push_back(static_cast<int>(i));
    state_->counter_of_life.push_back(value_of_transient_[static_cast<size_t>(life.transient)]);
    const Draft& first = drafts_[static_cast<size_t>(life.first)];
    for (const BufferAccess& access : first.accesses) {
      if (access.resource != life.transient || access.writes) continue;
      throw_error(ErrorClass::device, "schedule '{}': transient '{}' is read by '{}' before any pass has written it",
                  recorded_.name, resource(life.transient).name, first.name);
    }
  }
  const TransientLayout layout = recorded_.debug_memory              ? TransientLayout::debug
                                 : device().info().overlapping_parts ? TransientLayout::packed
                                                                     : TransientLayout::whole;
  state_->memory.emplace(device(), recorded_.name, recorded_.owner, std::move(specs), std::move(lives), layout);
}

int ScheduleCompiler::life_at(int transient, size_t step) const {
  int found = -1;
  for (const int life : lives_of_[static_cast<size_t>(transient)]) {
    if (state_->memory->lives()[static_cast<size_t>(life)].first <= static_cast<int>(step)) found = life;
  }
  return found;
}

MemoryRef ScheduleCompiler::memory_ref(int resource_index, size_t step) const {
  if (!resource(resource_index).is_transient()) return {resource_index, -1};
  return {resource_index, life_at(resource_index, step)};
}

/// Memory numbers of dependencies: callers' buffers, then arenas and slots, then counter values.
void ScheduleCompiler::derive_graph() {
  const int first_transient = static_cast<int>(recorded_.resources.size());
  const int first_counter = first_transient + state_->memory->memory_count();
  std::vector<std::vector<MemoryAccess>> accesses(drafts_.size());
  for (size_t i = 0; i < drafts_.size(); ++i) {
    for (const BufferAccess& access : drafts_[i].accesses) {
      const MemoryRef memory = memory_ref(access.resource, i);
      MemoryAccess range{memory.resource, 0, 1, access.writes};
      if (memory.life >= 0) {
        range = state_->memory->range(memory.life);
        range.memory += first_transient;
        range.writes = access.writes;
      }
      accesses[i].push_back(range);
    }
    for (const int value : drafts_[i].needs_counters) accesses[i].push_back({first_counter + value, 0, 1, false});
    if (drafts_[i].reads_counter >= 0) accesses[i].push_back({first_counter + drafts_[i].reads_counter, 0, 1, true});
  }
  state_->graph = DependencyGraph(static_cast<int>(drafts_.size()), derive_dependencies(accesses));
  std::vector<bool> is_last(drafts_.size(), true);
  for (const Dependency& edge : state_->graph.dependencies()) is_last[static_cast<size_t>(edge.from)] = false;
  for (size_t i = 0; i < is_last.size(); ++i) {
    if (is_last[i]) state_->last_steps.push_back(static_cast<int>(i));
  }
  name_memories();
}

void ScheduleCompiler::name_memories() {
  for (const RecordedResource& each : recorded_.resources) state_->memory_names.push_back(each.name);
  for (int i = 0; i < state_->memory->memory_count(); ++i) {
    std::string names;  // of all transients that share the arena or slot
    for (size_t life = 0; life < state_->memory->lives().size(); ++life) {
      if (state_->memory->range(static_cast<int>(life)).memory != i) continue;
      const std::string& name = state_->memory->name(static_cast<int>(life));
      if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    }
    state_->memory_names.push_back(names);
  }
  for (const int counter : counter_of_value_) {
    const RecordedCounter& recorded = recorded_.counters[static_cast<size_t>(counter)];
    state_->memory_names.push_back(fmt::format("{}[{}]", resource(recorded.resource).name, recorded.index));
  }
}

CompiledStep ScheduleCompiler::finish_step(size_t index) {
  Draft& from = drafts_[index];
  Step step;
  step.name = from.name;
  for (const BufferAccess& access : from.accesses) {
    const int life = memory_ref(access.resource, index).life;
    if (life < 0) {
      if (access.writes) step.written.push_back(access.resource);
      continue;
    }
    step.lives.push_back(life);
    if (state_->memory->lives()[static_cast<size_t>(life)].first == static_cast<int>(index))
      step.begins.push_back(life);
  }
  if (!from.recorded) {
    const RecordedCounter& counter =
        recorded_.counters[static_cast<size_t>(counter_of_value_[static_cast<size_t>(from.reads_counter)])];
    step.kind = StepKind::counter_read;
    step.counter = from.reads_counter;
    step.target = memory_ref(counter.resource, index);
    state_->counters.push_back({step.target, counter.index, 0});
    return step;
  }
  step.kind = from.recorded->kind;
  switch (step.kind) {
    case StepKind::kernel: finish_kernel(from, step); break;
    case StepKind::host: step.work = std::move(from.recorded->work); break;
    case StepKind::read_back:
      step.consume = std::move(from.recorded->consume);
      state_->has_read_back = true;
      [[fallthrough]];
    default: step.target = memory_ref(from.accesses.front().resource, index);
  }
  return step;
}

void ScheduleCompiler::choose_sizes(const RecordedStep& recorded, Step& step) const {
  const KernelSignature& signature = *recorded.signature;
  const size_t* required = signature.required_work_group_size;
  const DeviceInfo& info = device().info();
  if (!recorded.has_global && recorded.counter < 0) {
    throw_error(ErrorClass::device, "{}: no global size; call global() or global_by()", where(recorded));
  }
  step.global = recorded.has_global ? recorded.global : std::array<size_t, 3>{0, 1, 1};
  if (recorded.has_local) {
    step.local = recorded.local;
  } else if (required[0] > 0) {
    step.local = {required[0], required[1], required[2]};
  } else {
    step.local = {std::min<size_t>(64, info.max_work_group_size), 1, 1};
  }
  if (step.local[0] * step.local[1] * step.local[2] == 0) {
    throw_error(ErrorClass::device, "{}: local size {}x{}x{} is empty", where(recorded), step.local[0], step.local[1],
                step.local[2]);
  }
  if (required[0] > 0 && !std::equal(step.local.begin(), step.local.end(), required)) {
    throw_error(ErrorClass::device, "{}: local size {}x{}x{}, but the kernel requires {}x{}x{}", where(recorded),
                step.local[0], step.local[1], step.local[2], required[0], required[1], required[2]);
  }
  if (recorded.slice_items > 0) {
    step.slice_items = (recorded.slice_items + step.local[0] - 1) / step.local[0] * step.local[0];
  }
}

/// Some drivers abort the process on a launch that needs too much local memory.
void ScheduleCompiler::check_local_memory(const RecordedStep& recorded, const Step& step) const {
  cl_ulong bytes = 0;  // what the kernel declares itself; its arguments are not set yet
  check_opencl(clGetKernelWorkGroupInfo(step.kernel.get(), device().id(), CL_KERNEL_LOCAL_MEM_SIZE, sizeof(bytes),
                                        &bytes, nullptr),
               "clGetKernelWorkGroupInfo", step.kernel_name, device());
  for (const RecordedArgument& argument : recorded.arguments) {
    if (argument.kind == RecordedArgument::Kind::local) bytes += argument.bytes;
  }
  if (bytes > device().info().local_memory_bytes) {
    throw_error(ErrorClass::device, "{}: needs {} bytes of local memory, {} has {}", where(recorded), bytes,
                device().info().name, device().info().local_memory_bytes);
  }
}

void ScheduleCompiler::finish_kernel(const Draft& from, Step& step) {
  const RecordedStep& recorded = *from.recorded;
  step.program = recorded.program;
  step.kernel_name = recorded.signature->name;
  step.counter = from.global_counter;
  step.items_per_count = recorded.items_per_count;
  step.moved_bytes = recorded.moved_bytes;
  step.slice_base_position = from.bound.slice_base;
  choose_sizes(recorded, step);
  step.launch = fmt::format("{}/{}/{}", static_cast<const void*>(recorded.program.handle()), step.kernel_name,
                            fmt::join(step.local, "x"));
  state_->device->compile_progress().announce(step.launch);
  cl_int code = CL_SUCCESS;
  step.kernel = ClKernel(clCreateKernel(recorded.program.handle(), step.kernel_name.c_str(), &code));
  check_opencl(code, "clCreateKernel", step.kernel_name, device());
  check_local_memory(recorded, step);
  want_launch_code(recorded_, step, from.bound);
}

void ScheduleCompiler::set_kernel_arguments() {
  for (const RecordedVariable& variable : recorded_.variables)
    state_->variables.push_back({variable.name, variable.value, {}, false});
  for (size_t i = 0; i < drafts_.size(); ++i) {
    Step& step = state_->steps[i];
    if (step.kind != StepKind::kernel) continue;
    const auto set = [&](cl_uint position, size_t bytes, const void* value) {
      const std::string about = where(*drafts_[i].recorded);
      check_opencl(clSetKernelArg(step.kernel.get(), position, bytes, value), "clSetKernelArg", about, device());
    };
    for (cl_uint position = 0; position < drafts_[i].bound.by_position.size(); ++position) {
      const RecordedArgument* argument = drafts_[i].bound.by_position[position];
      if (!argument) {
        set(position, sizeof(step.slice_base), &step.slice_base);
      } else if (argument->kind == RecordedArgument::Kind::value) {
        set(position, argument->bytes, recorded_.values.data() + argument->offset);
      } else if (argument->kind == RecordedArgument::Kind::local) {
        set(position, argument->bytes, nullptr);
      } else if (argument->kind == RecordedArgument::Kind::variable) {
        VariableValue& variable = state_->variables[static_cast<size_t>(argument->index)];
        variable.uses.push_back({i, position});
        set(position, variable.value.size(), variable.value.data());
      } else {
        const MemoryRef memory = memory_ref(argument->index, i);
        step.buffers.push_back({position, memory});
        const cl_mem handle =
            memory.life >= 0 ? state_->memory->handle(memory.life) : resource(memory.resource).buffer.handle();
        if (handle) set(position, sizeof(cl_mem), &handle);  // a counted transient gets its memory when it is sized
      }
    }
  }
}

/// Overlap helps a pass that cannot fill the device alone while other passes can run beside it.
void ScheduleCompiler::decide_overlap() {
  const auto narrow = [&](const Step& step) {
    if (step.counter >= 0) return false;
    size_t groups = 1;
    for (size_t d = 0; d < 3; ++d) groups *= (step.global[d] + step.local[d] - 1) / step.local[d];
    return groups < 4 * static_cast<size_t>(device().info().compute_units);
  };
  const int count = static_cast<int>(state_->steps.size());
  for (int a = 0; a < count && !state_->overlap_pays; ++a) {
    const Step& step = state_->steps[static_cast<size_t>(a)];
    if (step.kind != StepKind::kernel || !narrow(step)) continue;
    for (int b = 0; b < count && !state_->overlap_pays; ++b) {
      state_->overlap_pays =
          state_->steps[static_cast<size_t>(b)].kind == StepKind::kernel && state_->graph.independent(a, b);
    }
  }
  if (device().info().compute_units < 2) state_->overlap_pays = false;
}

}  // namespace

Schedule ScheduleRecorder::compile() {
  std::unique_ptr<RecordedSchedule> recorded = std::move(recorded_);
  *this = ScheduleRecorder(*recorded->device, recorded->name, recorded->owner, recorded->debug_memory);
  Schedule schedule;
  schedule.state_ = ScheduleCompiler(*recorded).compile();
  return schedule;
}

}  // namespace lucarium
