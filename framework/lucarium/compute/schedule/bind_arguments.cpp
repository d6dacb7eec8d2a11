// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/schedule/bind_arguments.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"

namespace lucarium {
namespace {

std::vector<std::string> argument_names(const KernelSignature& signature) {
  std::vector<std::string> names;
  for (const KernelArgument& argument : signature.arguments) names.push_back(argument.name);
  return names;
}

size_t position_of(const KernelSignature& signature, std::string_view name) {
  const auto found = std::find_if(signature.arguments.begin(), signature.arguments.end(),
                                  [&](const KernelArgument& argument) { return argument.name == name; });
  return static_cast<size_t>(found - signature.arguments.begin());
}

bool is_buffer(ArgumentAccess access) { return access == ArgumentAccess::read || access == ArgumentAccess::read_write; }

std::string describe(const KernelArgument& argument) {
  switch (argument.access) {
    case ArgumentAccess::value: return fmt::format("a value of type {}", argument.type);
    case ArgumentAccess::local: return "local memory (local_memory())";
    default: return fmt::format("a buffer ({})", argument.type);
  }
}

std::string describe(const RecordedArgument& argument) {
  switch (argument.kind) {
    case RecordedArgument::Kind::buffer: return "a buffer";
    case RecordedArgument::Kind::local: return "local memory";
    default: return fmt::format("a value of type {}", argument.type);
  }
}

void check_kind(const std::string& where, const KernelArgument& declared, const RecordedArgument& bound) {
  bool right = false;
  switch (bound.kind) {
    case RecordedArgument::Kind::buffer: right = is_buffer(declared.access); break;
    case RecordedArgument::Kind::local: right = declared.access == ArgumentAccess::local; break;
    default: right = declared.access == ArgumentAccess::value && declared.type == bound.type;
  }
  if (!right) {
    throw_error(ErrorClass::device, "{}: argument '{}' is {}, but {} was bound to it", where, declared.name,
                describe(declared), describe(bound));
  }
}

void add_access(const std::string& where, BoundArguments& result, const KernelArgument& declared, int resource,
                bool discards, const std::vector<RecordedResource>& resources) {
  const bool writes = declared.access == ArgumentAccess::read_write;
  for (BufferAccess& access : result.accesses) {
    if (access.resource != resource) continue;
    if (access.writes != writes) {
      throw_error(ErrorClass::device,
                  "{}: buffer '{}' is bound to '{}' ({}) and also to {}; a buffer that a kernel writes may be bound "
                  "only to arguments that are not const",
                  where, resources[static_cast<size_t>(resource)].name, declared.name, writes ? "written" : "const",
                  writes ? "a const argument" : "an argument that is written");
    }
    access.discards = access.discards && discards;
    return;
  }
  result.accesses.push_back({resource, writes, discards});
}

/// Positions of the arguments that the pass discards.
std::vector<bool> find_discards(const std::string& where, const RecordedStep& step) {
  const KernelSignature& signature = *step.signature;
  std::vector<bool> discarded(signature.arguments.size(), false);
  for (const std::string& name : step.discards) {
    const size_t position = position_of(signature, name);
    if (position == signature.arguments.size()) {
      throw_error(ErrorClass::device, "{}: discards(\"{}\") names no argument{}", where, name,
                  suggest_name(name, argument_names(signature)));
    }
    if (signature.arguments[position].access != ArgumentAccess::read_write) {
      throw_error(ErrorClass::device, "{}: discards(\"{}\"), but the kernel does not write '{}'", where, name, name);
    }
    discarded[position] = true;
  }
  return discarded;
}

/// Names the argument that was meant: a driver's other name for it, or the nearest.
[[noreturn]] void fail_to_find(const std::string& where, const KernelSignature& signature, const std::string& name) {
  const std::string renamed = "_cl_" + name;  // as PoCL calls arguments that hide a function
  if (position_of(signature, renamed) < signature.arguments.size())
    throw_error(ErrorClass::device,
                "{}: the driver calls the argument '{}' '{}', since an OpenCL function has that name; rename it", where,
                name, renamed);
  throw_error(ErrorClass::device, "{}: the kernel has no argument '{}'{}", where, name,
              suggest_name(name, argument_names(signature)));
}

}  // namespace

BoundArguments bind_arguments(const std::string& where, const RecordedStep& step,
                              const std::vector<RecordedResource>& resources) {
  const KernelSignature& signature = *step.signature;
  const std::vector<bool> discarded = find_discards(where, step);
  BoundArguments result;
  result.by_position.resize(signature.arguments.size(), nullptr);
  for (const RecordedArgument& bound : step.arguments) {
    const size_t position = position_of(signature, bound.name);
    if (position == signature.arguments.size()) fail_to_find(where, signature, bound.name);
    if (result.by_position[position]) {
      throw_error(ErrorClass::device, "{}: argument '{}' is bound twice", where, bound.name);
    }
    const KernelArgument& declared = signature.arguments[position];
    check_kind(where, declared, bound);
    result.by_position[position] = &bound;
    if (bound.kind == RecordedArgument::Kind::buffer) {
      add_access(where, result, declared, bound.index, discarded[position], resources);
    }
  }
  for (size_t position = 0; position < signature.arguments.size(); ++position) {
    const KernelArgument& declared = signature.arguments[position];
    if (declared.name == slice_base_argument && declared.access == ArgumentAccess::value && declared.type == "uint" &&
        !result.by_position[position]) {
      result.slice_base = static_cast<int>(position);
    } else if (!result.by_position[position]) {
      throw_error(ErrorClass::device, "{}: argument '{}' is not bound; it is {}", where, declared.name,
                  describe(declared));
    }
  }
  if (step.slice_items > 0 && result.slice_base < 0) {
    throw_error(ErrorClass::device,
                "{}: slice() needs a kernel argument 'uint slice_base', which the schedule sets: add it to the kernel "
                "and do not bind it",
                where);
  }
  return result;
}

}  // namespace lucarium
