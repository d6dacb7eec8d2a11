// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace lucarium {

/// The command of the program with which a node does one task of an array, for SlurmExecutor alone: not in --help.
inline constexpr const char* array_task_command = "array-task";

/// Does the pieces of one task of the array in `folder` (SlurmBatch), one after another, each in a process of its own;
/// those that have ended already are left. What they leave is in the folder. Returns false when interrupted: what runs
/// then is not kept. Throws Error{input} where the folder cannot be read or written.
bool run_array_task(const std::filesystem::path& program, const std::filesystem::path& folder, size_t index);

}  // namespace lucarium
