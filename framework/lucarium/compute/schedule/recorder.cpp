// SPDX-License-Identifier: Apache-2.0
// Recording: passes, buffers, variables. Declared in schedule.h.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/compute/schedule/recorded_schedule.h"

namespace lucarium {
namespace {

std::unique_ptr<RecordedSchedule> new_recording(std::shared_ptr<Device> device, std::string name, std::string owner,
                                                bool debug_memory) {
  static std::atomic<uint64_t> last_id{0};
  auto recorded = std::make_unique<RecordedSchedule>();
  recorded->id = ++last_id;
  recorded->device = std::move(device);
  recorded->name = std::move(name);
  recorded->owner = std::move(owner);
  recorded->debug_memory = debug_memory;
  return recorded;
}

std::vector<std::byte> copy_bytes(const void* source, size_t bytes) {
  std::vector<std::byte> copy(bytes);
  std::memcpy(copy.data(), source, bytes);
  return copy;
}

}  // namespace

int RecordedSchedule::resource(const BufferRef& reference, std::string_view used_by) {
  if (reference.is_transient()) {
    if (reference.recording_ == id) return reference.transient_;
    throw_error(ErrorClass::device, "schedule '{}': '{}' uses a transient of another schedule", name, used_by);
  }
  if (!reference.buffer_) {
    throw_error(ErrorClass::device, "schedule '{}': '{}' uses a buffer that was never created", name, used_by);
  }
  const auto [found, fresh] =
      resource_of_handle.try_emplace(reference.buffer_.handle(), static_cast<int>(resources.size()));
  if (fresh) {
    RecordedResource& added = resources.emplace_back();
    added.name = reference.buffer_.name();
    added.buffer = reference.buffer_;
  }
  return found->second;
}

int RecordedSchedule::counter(const BufferRef& reference, size_t index, std::string_view used_by) {
  const int counted = resource(reference, used_by);
  for (size_t i = 0; i < counters.size(); ++i) {
    if (counters[i].resource == counted && counters[i].index == index) return static_cast<int>(i);
  }
  const RecordedResource& buffer = resources[static_cast<size_t>(counted)];
  if (!buffer.is_counted() && (index + 1) * sizeof(cl_uint) > buffer.bytes()) {
    throw_error(ErrorClass::device, "schedule '{}': counter {} of '{}' lies outside of the buffer's {} bytes", name,
                index, used_by, buffer.bytes());
  }
  counters.push_back({counted, index});
  return static_cast<int>(counters.size()) - 1;
}

PassBuilder& PassBuilder::global(size_t x, size_t y, size_t z) {
  RecordedStep& step = recorded_->steps[step_];
  step.global = {x, y, z};
  step.has_global = true;
  return *this;
}

PassBuilder& PassBuilder::local(size_t x, size_t y, size_t z) {
  RecordedStep& step = recorded_->steps[step_];
  step.local = {x, y, z};
  step.has_local = true;
  return *this;
}

PassBuilder& PassBuilder::global_by(const BufferRef& counter, size_t counter_index, double items_per_count) {
  const int index = recorded_->counter(counter, counter_index, recorded_->steps[step_].name);
  recorded_->steps[step_].counter = index;
  recorded_->steps[step_].items_per_count = items_per_count;
  return *this;
}

PassBuilder& PassBuilder::arg(std::string_view name, const BufferRef& buffer) {
  const int resource = recorded_->resource(buffer, name);
  RecordedArgument& argument = recorded_->steps[step_].arguments.emplace_back();
  argument.name = name;
  argument.kind = RecordedArgument::Kind::buffer;
  argument.index = resource;
  return *this;
}

bool PassBuilder::has_argument(std::string_view name) const {
  const std::vector<KernelArgument>& arguments = recorded_->steps[step_].signature->arguments;
  return std::any_of(arguments.begin(), arguments.end(), [&](const KernelArgument& a) { return a.name == name; });
}

PassBuilder& PassBuilder::arg_if_present(std::string_view name, const BufferRef& buffer) {
  return has_argument(name) ? arg(name, buffer) : *this;
}

PassBuilder& PassBuilder::value_argument(std::string_view name, std::string_view type, const void* value,
                                         size_t bytes) {
  RecordedArgument& argument = recorded_->steps[step_].arguments.emplace_back();
  argument.name = name;
  argument.kind = RecordedArgument::Kind::value;
  argument.type = type;
  argument.bytes = bytes;
  argument.offset = recorded_->values.size();
  const auto* first = static_cast<const std::byte*>(value);
  recorded_->values.insert(recorded_->values.end(), first, first + bytes);
  return *this;
}

PassBuilder& PassBuilder::variable_argument(std::string_view name, std::string_view type, int variable,
                                            uint64_t recording) {
  if (recording != recorded_->id) {
    throw_error(ErrorClass::device, "schedule '{}': pass '{}': argument '{}' uses a variable of another schedule",
                recorded_->name, recorded_->steps[step_].name, name);
  }
  RecordedArgument& argument = recorded_->steps[step_].arguments.emplace_back();
  argument.name = name;
  argument.kind = RecordedArgument::Kind::variable;
  argument.type = type;
  argument.index = variable;
  return *this;
}

PassBuilder& PassBuilder::local_memory(std::string_view name, size_t bytes) {
  RecordedArgument& argument = recorded_->steps[step_].arguments.emplace_back();
  argument.name = name;
  argument.kind = RecordedArgument::Kind::local;
  argument.bytes = bytes;
  return *this;
}

PassBuilder& PassBuilder::discards(std::string_view argument) {
  recorded_->steps[step_].discards.emplace_back(argument);
  return *this;
}

PassBuilder& PassBuilder::slice(size_t work_items) {
  recorded_->steps[step_].slice_items = work_items;
  return *this;
}

PassBuilder& PassBuilder::moves_bytes(size_t bytes) {
  recorded_->steps[step_].moved_bytes = bytes;
  return *this;
}

ScheduleRecorder::ScheduleRecorder(Device& device, std::string name, std::string owner, bool debug_memory)
    : recorded_(new_recording(device.shared_from_this(), std::move(name), std::move(owner), debug_memory)) {}
ScheduleRecorder::~ScheduleRecorder() = default;
ScheduleRecorder::ScheduleRecorder(ScheduleRecorder&&) noexcept = default;
ScheduleRecorder& ScheduleRecorder::operator=(ScheduleRecorder&&) noexcept = default;

Device& ScheduleRecorder::device() const { return *recorded_->device; }

PassBuilder ScheduleRecorder::pass(std::string name, const Program& program, std::string_view kernel) {
  const KernelSignature& signature = program.signature(kernel);
  RecordedStep& step = recorded_->steps.emplace_back();
  step.name = std::move(name);
  step.program = program;
  step.signature = &signature;
  step.arguments.reserve(signature.arguments.size());
  return PassBuilder(*recorded_, recorded_->steps.size() - 1);
}

BufferRef ScheduleRecorder::transient_bytes(std::string name, size_t element_bytes, size_t count,
                                            const std::string& remedy) {
  BufferRef reference;
  reference.transient_ = static_cast<int>(recorded_->resources.size());
  reference.recording_ = recorded_->id;
  RecordedResource& added = recorded_->resources.emplace_back();
  added.name = std::move(name);
  added.element_bytes = element_bytes;
  added.count = count;
  added.remedy = remedy;
  return reference;
}

BufferRef ScheduleRecorder::transient_counted(std::string name, size_t element_bytes, const BufferRef& counter,
                                              size_t index, size_t elements_per_count, const std::string& remedy) {
  const int counter_index = recorded_->counter(counter, index, name);
  const BufferRef reference = transient_bytes(std::move(name), element_bytes, elements_per_count, remedy);
  recorded_->resources.back().counter = counter_index;
  return reference;
}

int ScheduleRecorder::add_variable(std::string name, std::string_view type, const void* value, size_t bytes,
                                   uint64_t& recording) {
  recording = recorded_->id;
  recorded_->variables.push_back({std::move(name), type, copy_bytes(value, bytes)});
  return static_cast<int>(recorded_->variables.size()) - 1;
}

void ScheduleRecorder::host_step(std::string name, const std::vector<BufferRef>& reads,
                                 const std::vector<BufferRef>& writes, std::function<void()> work) {
  RecordedStep step;
  step.kind = StepKind::host;
  for (const BufferRef& buffer : reads) step.reads.push_back(recorded_->resource(buffer, name));
  for (const BufferRef& buffer : writes) step.writes.push_back(recorded_->resource(buffer, name));
  step.name = std::move(name);
  step.work = std::move(work);
  recorded_->steps.push_back(std::move(step));
}

void ScheduleRecorder::read_back(std::string name, const BufferRef& buffer,
                                 std::function<void(std::span<const std::byte>)> consume) {
  RecordedStep step;
  step.kind = StepKind::read_back;
  step.reads.push_back(recorded_->resource(buffer, name));
  step.name = std::move(name);
  step.consume = std::move(consume);
  recorded_->steps.push_back(std::move(step));
}

void ScheduleRecorder::fill_zero(std::string name, const BufferRef& buffer) {
  RecordedStep step;
  step.kind = StepKind::fill_zero;
  step.writes.push_back(recorded_->resource(buffer, name));
  step.name = std::move(name);
  recorded_->steps.push_back(std::move(step));
}

}  // namespace lucarium
