// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/scene/load_scene.h"

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

  /// Adds a warning unless it was given before.
  template <class... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) {
    std::string text = fmt::format(format, std::forward<Args>(args)...);
    if (std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end()) warnings_.push_back(std::move(text));
  }

  /// Counts memory that the file makes us allocate; refuses files that ask for more than a scene of max_triangles
  /// could need. Small files may refer to the same data, or to none, very often.
  void spend_bytes(uint64_t bytes) {
    spent_ += bytes;
    const uint64_t limit = options.max_triangles * bytes_per_triangle + (1u << 20);
    if (spent_ > limit) {
      fail("its meshes, instances and animations need more than {} MiB, the most for {} triangles", limit >> 20,
           options.max_triangles);
    }
  }

  const std::string& name() const { return name_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  const ImportOptions& options;

 private:
  /// Indices, and two thirds of a vertex with all attributes and one morph target, rounded up.
  static constexpr uint64_t bytes_per_triangle = 96;

  std::string name_;
  std::vector<std::string> warnings_;
  uint64_t spent_ = 0;
};

/// "mesh 3" or "mesh 3 'wall'".
inline std::string label(const char* kind, size_t index, const std::string& name) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} {} '{}'", kind, index, name);
}

}  // namespace lucarium::gltf
