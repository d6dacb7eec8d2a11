// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/schedule.h"

#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/compute/schedule/schedule_state.h"

namespace lucarium {
namespace {

std::string dot_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
  return result + "\"";
}

const char* shape(StepKind kind) {
  switch (kind) {
    case StepKind::kernel: return "box";
    case StepKind::host: return "house";
    case StepKind::fill_zero: return "cds";
    case StepKind::read_back: return "invhouse";
    case StepKind::counter_read: return "diamond";
  }
  return "box";
}

const char* style(Hazard hazard) { return hazard == Hazard::read_after_write ? "solid" : "dashed"; }

}  // namespace

Schedule::State::~State() {
  if (!in_flight) return;
  try {
    device->finish();  // arenas and staging must outlive what is enqueued
  } catch (const Error&) {
    // A destructor cannot throw; the run has already reported the command that failed.
  }
}

cl_mem Schedule::State::handle(const MemoryRef& memory_of) const {
  if (memory_of.life >= 0) return memory->handle(memory_of.life);
  const size_t index = static_cast<size_t>(memory_of.resource);
  if (!scratch_copies.empty() && scratch_copies[index]) return scratch_copies[index].handle();
  return resources[index].buffer.handle();
}

size_t Schedule::State::bytes(const MemoryRef& memory_of) const {
  return memory_of.life >= 0 ? memory->bytes(memory_of.life)
                             : resources[static_cast<size_t>(memory_of.resource)].bytes();
}

std::string Schedule::State::where(const CompiledStep& step) const {
  if (step.kind != StepKind::kernel) return fmt::format("schedule '{}': step '{}'", name, step.name);
  return fmt::format("schedule '{}': pass '{}' (kernel '{}')", name, step.name, step.kernel_name);
}

Schedule::Schedule() = default;
Schedule::~Schedule() = default;
Schedule::Schedule(Schedule&&) noexcept = default;
Schedule& Schedule::operator=(Schedule&&) noexcept = default;

const std::string& Schedule::name() const { return state_->name; }
size_t Schedule::pass_count() const { return state_->steps.size(); }
const std::string& Schedule::pass_name(size_t step) const { return state_->steps.at(step).name; }
size_t Schedule::transient_bytes() const { return state_->memory->allocated_bytes(); }
size_t Schedule::transient_bytes_unshared() const { return state_->memory->unshared_bytes(); }

std::vector<std::pair<int, int>> Schedule::edges() const {
  std::vector<std::pair<int, int>> result;
  for (const Dependency& edge : state_->graph.dependencies()) result.push_back({edge.from, edge.to});
  return result;
}

std::string Schedule::dot() const {
  std::string text = fmt::format("digraph {} {{\n  node [fontname=\"sans-serif\"];\n", dot_quoted(state_->name));
  for (size_t i = 0; i < state_->steps.size(); ++i) {
    const CompiledStep& step = state_->steps[i];
    std::string label = step.name;
    if (step.kind == StepKind::kernel && step.kernel_name != step.name) label += " (" + step.kernel_name + ")";
    text += fmt::format("  p{} [shape={}, label={}];\n", i, shape(step.kind), dot_quoted(label));
  }
  for (const Dependency& edge : state_->graph.dependencies()) {
    text += fmt::format("  p{} -> p{} [style={}, label={}];\n", edge.from, edge.to, style(edge.hazard),
                        dot_quoted(state_->memory_names[static_cast<size_t>(edge.memory)]));
  }
  return text + "}\n";
}

void Schedule::set_variable(int index, uint64_t recording, const void* value, size_t bytes) {
  if (!state_ || recording != state_->id) {
    throw_error(ErrorClass::device, "schedule '{}': set() got a variable of another schedule",
                state_ ? state_->name : "");
  }
  VariableValue& variable = state_->variables[static_cast<size_t>(index)];
  if (std::memcmp(variable.value.data(), value, bytes) == 0) return;
  std::memcpy(variable.value.data(), value, bytes);
  variable.changed = true;
}

}  // namespace lucarium
