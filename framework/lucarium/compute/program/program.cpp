// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/program.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/hash.h"
#include "lucarium/base/processor_time.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compute/program/built_program.h"
#include "lucarium/compute/program/pocl_files.h"
#include "lucarium/compute/program/source_library.h"

namespace lucarium {
namespace {

std::optional<Hash128> request_of(const SourceLibrary& library, const ProgramSpec& spec) {
  const std::optional<Hash128> sources = library.fingerprint();
  if (!sources) return std::nullopt;
  Hasher hasher;
  hasher.add(*sources).add(spec.name).add(spec.mad_enable).add(static_cast<uint64_t>(spec.files.size()));
  for (const std::string& file : spec.files) hasher.add(file);
  for (const auto& [name, value] : spec.defines) hasher.add(name).add(value);
  return hasher.finish();
}

std::atomic<double> all_processor_seconds = 0;

}  // namespace

struct Program::State : std::enable_shared_from_this<Program::State> {
  std::shared_ptr<Device> device;
  std::shared_ptr<BuiltProgram> built;
  double build_seconds = 0;

  /// The programs that are ready.
  struct Registry {
    std::mutex mutex;
    std::set<State*> states;
  };
  /// Never destroyed: programs that are static objects themselves may outlive whatever was made after them.
  static Registry& registry() {
    static Registry& instance = *new Registry;
    return instance;
  }

  /// A program that somebody has and that was asked for in the same words, or null.
  static std::shared_ptr<State> find(const Device& device, const std::optional<Hash128>& request) {
    if (!request) return nullptr;
    const std::lock_guard lock(registry().mutex);
    for (State* state : registry().states) {
      if (state->device.get() != &device || state->built->request != request) continue;
      if (std::shared_ptr<State> shared = state->weak_from_this().lock()) return shared;
    }
    return nullptr;
  }

  void enter() {
    const std::lock_guard lock(registry().mutex);
    registry().states.insert(this);
  }

  ~State() {
    const std::lock_guard lock(registry().mutex);  // others may have the same BuiltProgram, or get it
    registry().states.erase(this);
    if (built) built->cache_specialized_kernels(*device);
  }
};

Program::Program(Device& device, const SourceLibrary& library, const ProgramSpec& spec) {
  const std::optional<Hash128> request = request_of(library, spec);
  state_ = State::find(device, request);
  if (state_) return;
  state_ = std::make_shared<State>();
  const Stopwatch watch;
  const double before = processor_seconds();
  state_->device = device.shared_from_this();
  if (request) state_->built = device.kept_programs().find(*request);
  if (!state_->built) {
    auto built = std::make_shared<BuiltProgram>();
    built->name = spec.name;
    built->request = request;
    built->make(device, spec, program_text(spec, library.preprocess(spec.files)));
    if (device.kernel_compilers() && !built->driver_program.empty()) built->source.options = built->text.options;
    if (built->source.options.empty()) built->text = {};
    state_->built = std::move(built);
  }
  state_->enter();
  if (request) device.kept_programs().keep(*request, state_->built);
  state_->build_seconds = watch.seconds();
  device.add_program_seconds(state_->build_seconds);
  all_processor_seconds += processor_seconds() - before;
}

double program_processor_seconds() { return all_processor_seconds; }

Program make_program(Device& device, const EmbeddedSources& sources, std::vector<std::string> files,
                     std::map<std::string, std::string> defines) {
  SourceLibrary library;
  library.add(sources);
  const std::string name = files.at(0);
  for (std::string& file : files) file += ".cl";
  return Program(device, library, {name, std::move(files), std::move(defines)});
}

void cache_specialized_kernels(const Device& device) noexcept {
  Program::State::Registry& registry = Program::State::registry();
  const std::lock_guard lock(registry.mutex);
  for (Program::State* state : registry.states) {
    if (state->device.get() == &device) state->built->cache_specialized_kernels(*state->device);
  }
}
const std::string& Program::name() const { return state_->built->name; }
Device& Program::device() const { return *state_->device; }
cl_program Program::handle() const { return state_->built->program.get(); }
bool Program::lacks_launch_code(const std::string& kernel, const std::array<size_t, 3>& local, bool is_large) const {
  const bool possible = !state_->built->source.options.empty();
  return possible && !has_launch_code(state_->built->driver_program, kernel, local, is_large);
}
const ProgramSource& Program::source() const {
  BuiltProgram& built = *state_->built;
  if (built.source.file.empty()) built.source.file = write_source(built.key, built.text.source);
  built.text = {};
  return built.source;
}
bool Program::from_cache() const { return state_->built->from_cache; }
bool Program::declares_built_ins() const { return state_->built->declares_built_ins; }
double Program::build_seconds() const { return state_->build_seconds; }

const KernelSignature& Program::signature(std::string_view kernel) const {
  const auto found = state_->built->signatures.find(kernel);
  if (found != state_->built->signatures.end()) return found->second;
  throw_error(ErrorClass::device, "program {} has no kernel '{}'{}", name(), kernel,
              suggest_name(kernel, kernel_names()));
}

std::vector<std::string> Program::kernel_names() const { return state_->built->kernel_names(); }

}  // namespace lucarium
