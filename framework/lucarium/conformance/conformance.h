// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/compute/device/device.h"
#include "lucarium/technique/plugin.h"

namespace lucarium {

enum class Verdict {
  passed,
  failed,
  skipped,      ///< could not be done here; `measured` says why
  not_claimed,  ///< the technique does not say that it can do this
};

/// One line of the table.
struct CheckResult {
  std::string name;  ///< "light/point", unique
  Verdict verdict = Verdict::passed;
  std::string measured;  ///< with numbers
  std::string required;  ///< what passes
  double seconds = 0;
};

struct ConformanceOptions {
  std::vector<std::pair<std::string, std::string>> parameters;  ///< of the technique, set in every check
  bool full = false;              ///< at the technique's defaults instead of its check_parameters; may take hours
  std::vector<std::string> only;  ///< run the checks whose names begin with one of these; empty: all
  std::filesystem::path program;  ///< lucarium, for checks that need a process of their own; empty: they are skipped
  std::vector<std::filesystem::path> technique_folders = {};  ///< where that program looks for plug-ins first
  DeviceOptions device = {};                                  ///< of the device under test, for that program
  std::function<void(size_t index, size_t count, const std::string& name)> on_check = {};  ///< before each, from 0
  std::function<void(const CheckResult&)> on_result = {};                                  ///< as they come
};

/// What is set in every check: the technique's check_parameters unless `full`, then those of the options.
std::vector<std::pair<std::string, std::string>> effective_parameters(const TechniqueInfo& info,
                                                                      const ConformanceOptions& options);

/// What is set in the check `oclgrind`: unless `full`, the technique's oclgrind_parameters come between those two.
std::vector<std::pair<std::string, std::string>> oclgrind_parameters(const TechniqueInfo& info,
                                                                     const ConformanceOptions& options);

/// What the technique admits with those: no check asks for less.
double admitted_bias(const TechniqueType& type, const ConformanceOptions& options);

/// Runs the conformance kit (docs/conformance.md) on one technique. What a technique throws fails the check it happened
/// in and no other. Stops early when an interrupt is requested, with the checks that were done by then. Throws
/// Error{usage} for parameters that the technique refuses, or when `only` matches nothing.
std::vector<CheckResult> check_technique(std::shared_ptr<Device> device, const TechniqueRegistry& registry,
                                         const TechniqueType& type, const ConformanceOptions& options);

/// "passed", "failed", "skipped", "not claimed".
const char* verdict_name(Verdict verdict);

}  // namespace lucarium
