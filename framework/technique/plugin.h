// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/technique/technique.h"

#define LUCARIUM_ABI_VERSION 1u

namespace lucarium {

/// Plain data at the start of every plug-in's descriptor. The loader checks it before calling or reading anything else.
struct PluginHeader {
  char magic[8];          ///< "LUCARIUM"
  uint32_t abi;           ///< LUCARIUM_ABI_VERSION
  uint32_t header_bytes;  ///< sizeof(PluginHeader)
  char compiler[64];      ///< name and major version
  char standard_library[64];
  char sanitizers[64];
};

struct TechniqueDescriptor {
  PluginHeader header;
  TechniqueInfo (*info)();
  std::unique_ptr<Technique> (*create)();
};

/// A plug-in exports exactly one C function of this name; the last lines of its main source are
///   LUCARIUM_EXPORT_TECHNIQUE(my_info, my_create)
#define LUCARIUM_EXPORT_TECHNIQUE(info_function, create_function)                                       \
  extern "C" __attribute__((visibility("default"))) const lucarium::TechniqueDescriptor* lucarium_technique() { \
    static const lucarium::TechniqueDescriptor descriptor = {lucarium::detail::plugin_header(), info_function, \
                                                             create_function};                          \
    return &descriptor;                                                                                 \
  }

/// A loaded technique type. The library stays open while any copy or any created technique lives.
class TechniqueType {
 public:
  const TechniqueInfo& info() const { return info_; }
  const std::filesystem::path& file() const { return file_; }
  std::unique_ptr<Technique> create() const;

 private:
  friend class TechniqueRegistry;
  TechniqueInfo info_;
  std::filesystem::path file_;
  std::shared_ptr<void> library_;
  const TechniqueDescriptor* descriptor_ = nullptr;
};

/// A plug-in that could not be used, and why.
struct PluginFailure {
  std::filesystem::path file;
  std::string reason;
};

/// Finds and loads plug-ins: --technique-path, then LUCARIUM_TECHNIQUE_PATH, then lib/lucarium/techniques relative to
/// the executable and to the framework library. The first of a name wins.
class TechniqueRegistry {
 public:
  explicit TechniqueRegistry(const std::vector<std::filesystem::path>& extra_folders = {});
  const std::vector<TechniqueType>& types() const { return types_; }
  const std::vector<PluginFailure>& failures() const { return failures_; }
  const std::vector<std::filesystem::path>& searched() const { return searched_; }
  /// Throws Error{technique} with the nearest name, the paths searched and the failures.
  const TechniqueType& find(const std::string& name) const;

 private:
  void load(const std::filesystem::path& file);
  std::vector<TechniqueType> types_;
  std::vector<PluginFailure> failures_;
  std::vector<std::filesystem::path> searched_;
};

namespace detail {
/// The toolchain identity of the translation unit that includes this header.
inline PluginHeader plugin_header() {
  PluginHeader header{};
  const auto copy = [](char* target, size_t size, const std::string& text) { text.copy(target, size - 1); };
  copy(header.magic, sizeof header.magic + 1, "LUCARIUM");
  header.abi = LUCARIUM_ABI_VERSION;
  header.header_bytes = sizeof(PluginHeader);
#if defined(__clang__)
  copy(header.compiler, sizeof header.compiler, "clang " + std::to_string(__clang_major__));
#else
  copy(header.compiler, sizeof header.compiler, "gcc " + std::to_string(__GNUC__));
#endif
#if defined(_LIBCPP_VERSION)
  copy(header.standard_library, sizeof header.standard_library, "libc++");
#else
  copy(header.standard_library, sizeof header.standard_library,
       std::string("libstdc++ cxx11abi=") + (_GLIBCXX_USE_CXX11_ABI ? "1" : "0"));
#endif
#if defined(__SANITIZE_ADDRESS__)
  copy(header.sanitizers, sizeof header.sanitizers, "address");
#endif
  return header;
}
}  // namespace detail

}  // namespace lucarium
