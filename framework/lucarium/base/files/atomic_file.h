// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace lucarium {

/// Runs `write(temporary_path)` on a fresh path in the folder of `target`, flushes the file to disk and renames it
/// onto `target`. Readers see the old file or the whole new one, never a part; on any failure the temporary is
/// removed and `target` is untouched. The temporary keeps the extension of `target`, since image libraries choose
/// the format by it. Throws Error{input} with path and reason (disk full, not writable, …).
void write_file_atomically(const std::filesystem::path& target,
                           const std::function<void(const std::filesystem::path&)>& write);

/// The same for bytes already in memory.
void write_file_atomically(const std::filesystem::path& target, std::string_view bytes);

/// Throws Error{input} for what is not there, and for folders, pipes and devices: reading them fails, or waits for
/// ever. Whoever opens a file to read it asks this first.
void require_regular_file(const std::filesystem::path& path);

/// Whole file as bytes; throws Error{input} with path and reason. Files above `limit_bytes` are refused.
std::string read_file(const std::filesystem::path& path, uintmax_t limit_bytes = uintmax_t{1} << 32);

}  // namespace lucarium
