// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/technique/technique.h"

/// Of the interface of plug-ins, and in the library's name. What raises it: docs/adding_a_technique.md.
#define LUCARIUM_ABI_VERSION 15u

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
#define LUCARIUM_EXPORT_TECHNIQUE(info_function, create_function)                                               \
  extern "C" __attribute__((visibility("default"))) const lucarium::TechniqueDescriptor* lucarium_technique() { \
    static const lucarium::TechniqueDescriptor descriptor = {lucarium::detail::plugin_header(), info_function,  \
                                                             create_function};                                  \
    return &descriptor;                                                                                         \
  }

/// A loaded technique type. A plug-in that was loaded stays in memory until the process ends, so that techniques,
/// errors and strings that came from it outlive every registry.
class TechniqueType {
 public:
  const TechniqueInfo& info() const { return info_; }
  const std::filesystem::path& file() const { return file_; }
  /// Throws Error{technique} naming the technique, whatever the plug-in throws.
  std::unique_ptr<Technique> create() const;
  /// Technique::admitted_bias() of an instance of this type.
  double admitted_bias(const Technique& technique) const { return technique.admitted_bias(info_.capabilities.bias); }

 private:
  friend class TechniqueRegistry;
  TechniqueInfo info_;
  std::filesystem::path file_;
  const TechniqueDescriptor* descriptor_ = nullptr;
};

/// A plug-in that could not be used, and why.
struct PluginFailure {
  std::filesystem::path file;
  std::string reason;
};

/// Finds and loads plug-ins (*.so): --technique-path, then LUCARIUM_TECHNIQUE_PATH, then lib/lucarium/techniques
/// relative to the executable and to the framework library. The first of a name wins. What cannot be loaded, and
/// folders that were named and are not there, are failures(); they never stop the others.
class TechniqueRegistry {
 public:
  explicit TechniqueRegistry(const std::vector<std::filesystem::path>& extra_folders = {});
  const std::vector<TechniqueType>& types() const { return types_; }
  const std::vector<PluginFailure>& failures() const { return failures_; }
  const std::vector<std::filesystem::path>& searched() const { return searched_; }
  /// Throws Error{technique} with the nearest name and the folders searched; a plug-in of that file name that could not
  /// be loaded gives its reason; details() have all failures.
  const TechniqueType& find(const std::string& name) const;

 private:
  void load(const std::filesystem::path& file);
  std::vector<TechniqueType> types_;
  std::vector<PluginFailure> failures_;
  std::vector<std::filesystem::path> searched_;
};

namespace detail {

#if defined(__has_feature)
#define LUCARIUM_HAS_FEATURE(feature) __has_feature(feature)
#else
#define LUCARIUM_HAS_FEATURE(feature) 0
#endif

/// The toolchain identity of the translation unit that includes this header. Internal linkage on purpose: were it
/// `inline`, the dynamic linker would give a plug-in the framework's copy, and every check would pass.
[[maybe_unused]] static PluginHeader plugin_header() {
  PluginHeader header{};
  const auto copy = [](char* target, size_t size, const std::string& text) { text.copy(target, size); };
  copy(header.magic, sizeof header.magic, "LUCARIUM");
  header.abi = LUCARIUM_ABI_VERSION;
  header.header_bytes = sizeof(PluginHeader);
#if defined(__clang__)
  copy(header.compiler, sizeof header.compiler - 1, "clang " + std::to_string(__clang_major__));
#else
  copy(header.compiler, sizeof header.compiler - 1, "gcc " + std::to_string(__GNUC__));
#endif
#if defined(_LIBCPP_VERSION)
  std::string library = "libc++";
#else
  std::string library = _GLIBCXX_USE_CXX11_ABI ? "libstdc++ cxx11abi=1" : "libstdc++ cxx11abi=0";
#endif
#if defined(_GLIBCXX_DEBUG)
  library += " debug";
#endif
  copy(header.standard_library, sizeof header.standard_library - 1, library);
#if defined(__SANITIZE_ADDRESS__) || LUCARIUM_HAS_FEATURE(address_sanitizer)
  copy(header.sanitizers, sizeof header.sanitizers - 1, "address");
#elif defined(__SANITIZE_THREAD__) || LUCARIUM_HAS_FEATURE(thread_sanitizer)
  copy(header.sanitizers, sizeof header.sanitizers - 1, "thread");
#endif
  return header;
}

#undef LUCARIUM_HAS_FEATURE

}  // namespace detail

}  // namespace lucarium
