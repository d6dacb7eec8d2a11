// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace lucarium {

/// Below a result folder: what jobs of a scheduler need and leave until it is taken.
inline constexpr const char* slurm_folder = "slurm";
inline constexpr const char* slurm_references = "references";  ///< in it: the arrays of references

/// The first thing in a folder that a comparison would write over and that no comparison wrote: there is no
/// comparison.json in the form in which comparisons write it. Empty where there is none.
std::filesystem::path find_foreign_file(const std::filesystem::path& folder);

/// Removes the files that a comparison has written into a folder, comparison.json last. Files of other names stay.
void remove_results(const std::filesystem::path& folder);

/// Removes the files of one of its folders that have names which comparisons give, and the folder if it is empty then.
void remove_written_files(const std::filesystem::path& folder);

}  // namespace lucarium
