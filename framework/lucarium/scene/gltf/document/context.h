// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string>
#include <unordered_set>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/scene/import_options.h"

namespace lucarium::gltf {

/// What every stage of one import shares: how the file is called, the limits, and the warnings so far.
class ImportContext {
 public:
  ImportContext(std::string shown_name, const ImportOptions& import_options)
      : options(import_options), name_(std::move(shown_name)) {}

  /// Throws Error{input} "file: what"; `where` is a JSON pointer or an element ("mesh 3 'wall'").
  template <class... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
    throw Error(ErrorClass::input, name_ + ": " + fmt::format(format, std::forward<Args>(args)...));
  }

  /// Adds a warning unless it was given before. Of very many, the first are kept and the rest counted.
  template <class... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) {
    std::string text = fmt::format(format, std::forward<Args>(args)...);
    if (!known_warnings_.insert(text).second) return;
    if (warnings_.size() < max_warnings)
      warnings_.push_back(std::move(text));
    else
      ++further_warnings_;
  }

  /// Says how large the file and the buffers it names are.
  void count_input_bytes(uint64_t bytes) { input_ += bytes; }

  /// Counts memory that the file makes us allocate. Small files may refer to the same data, or to none, very often:
  /// what they may ask for is bounded by their own size and by what max_triangles triangles could need.
  void spend_bytes(uint64_t bytes) {
    spent_ += bytes;
    const uint64_t limit = std::min(options.max_triangles * bytes_per_triangle + (1u << 20), 64 * input_ + (1u << 30));
    if (spent_ <= limit) return;
    fail(
        "its meshes, instances and animations need more than {} MiB, the maximum for {} triangles and {} bytes of data",
        limit >> 20, options.max_triangles, input_);
  }

  const std::string& name() const { return name_; }
  std::vector<std::string> warnings() const {
    std::vector<std::string> result = warnings_;
    if (further_warnings_) result.push_back(fmt::format("{} further warnings were left out", further_warnings_));
    return result;
  }

  const ImportOptions& options;

 private:
  /// Indices, and two thirds of a vertex with all attributes and one morph target, rounded up.
  static constexpr uint64_t bytes_per_triangle = 96;

  static constexpr size_t max_warnings = 100;

  std::string name_;
  std::vector<std::string> warnings_;
  std::unordered_set<std::string> known_warnings_;
  size_t further_warnings_ = 0;
  uint64_t spent_ = 0, input_ = 0;
};

/// "mesh 3" or "mesh 3 'wall'".
inline std::string label(const char* kind, size_t index, const std::string& name) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} {} '{}'", kind, index, name);
}

}  // namespace lucarium::gltf
