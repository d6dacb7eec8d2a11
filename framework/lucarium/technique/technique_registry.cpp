// SPDX-License-Identifier: Apache-2.0
// The registry of plug-ins: found, checked, loaded. Declared in plugin.h.
#include <dlfcn.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/technique/library_file.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_folders.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

/// Folder of the executable and of this library, so that nothing depends on the working directory.
std::vector<fs::path> own_folders() {
  std::vector<fs::path> folders;
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure);
  if (!failure) folders.push_back(program.parent_path());
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_folders), &info) && info.dli_fname) {
    folders.push_back(fs::weakly_canonical(info.dli_fname, failure).parent_path());
  }
  return folders;
}

std::string abi_mismatch(std::string_view theirs) {
  return fmt::format("is built for ABI {}, this program has {}; rebuild it", theirs, LUCARIUM_ABI_VERSION);
}

/// Why dlopen() refused a plug-in. The framework library is called after its ABI: one that asks for another finds none.
std::string open_failure(const std::string& message) {
  constexpr std::string_view library = "liblucarium.so.";
  const size_t at = message.find(library);
  if (at == std::string::npos) return "cannot be loaded: " + message;
  const size_t begin = at + library.size();
  return abi_mismatch(std::string_view(message).substr(begin, message.find_first_not_of("0123456789", begin) - begin));
}

/// Empty when the plug-in was made by the same toolchain for the same interface; else why not.
std::string header_mismatch(const PluginHeader& theirs) {
  const PluginHeader ours = detail::plugin_header();
  if (std::memcmp(theirs.magic, ours.magic, sizeof ours.magic) != 0) return "is not a Lucarium technique (wrong magic)";
  if (theirs.abi != ours.abi) return abi_mismatch(std::to_string(theirs.abi));
  if (theirs.header_bytes != ours.header_bytes) return "has a descriptor of another size; rebuild it";
  const auto differs = [](const char* what, const char* a, const char* b) {
    return std::strncmp(a, b, sizeof PluginHeader::compiler) == 0
               ? std::string()
               : fmt::format("is built with {} '{:.63}', this program with '{}'; rebuild it", what, a, b);
  };
  for (std::string reason : {differs("compiler", theirs.compiler, ours.compiler),
                             differs("standard library", theirs.standard_library, ours.standard_library),
                             differs("sanitizers", theirs.sanitizers, ours.sanitizers)}) {
    if (!reason.empty()) return reason;
  }
  return "";
}

/// Calls into a plug-in; whatever it throws leaves as lucarium::Error that begins with `who`.
template <class Call>
auto call_plugin(const std::string& who, Call&& call) {
  try {
    return call();
  } catch (const Error& error) {
    throw error.with_context(who);
  } catch (const std::exception& error) {
    throw_error(ErrorClass::technique, "{}: {}", who, error.what());
  } catch (...) {
    throw_error(ErrorClass::technique, "{}: threw something that is not an exception", who);
  }
}

bool is_technique_name(const std::string& name) {
  return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

/// A handle that closes the library unless the plug-in is accepted.
struct OpenLibrary {
  void* handle;
  explicit OpenLibrary(const fs::path& file) : handle(nullptr) {
    if (const std::string damage = library_damage(file); !damage.empty())
      throw_error(ErrorClass::technique, "cannot be loaded: {}", damage);
    handle = ::dlopen(fs::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) throw_error(ErrorClass::technique, "{}", open_failure(::dlerror()));
  }
  ~OpenLibrary() {
    if (handle) ::dlclose(handle);
  }
  OpenLibrary(const OpenLibrary&) = delete;
  OpenLibrary& operator=(const OpenLibrary&) = delete;
  void keep() { handle = nullptr; }
};

}  // namespace

std::unique_ptr<Technique> TechniqueType::create() const {
  return call_plugin(fmt::format("technique {}", info_.name), [this] {
    std::unique_ptr<Technique> technique = descriptor_->create();
    if (!technique) throw_error(ErrorClass::technique, "create() returned nothing");
    return technique;
  });
}

std::vector<fs::path> technique_folders(const std::vector<fs::path>& extra) {
  std::vector<fs::path> folders = extra;
  if (const char* list = std::getenv("LUCARIUM_TECHNIQUE_PATH")) {
    const std::string text(list);
    for (size_t begin = 0; begin < text.size();) {
      const size_t end = std::min(text.find(':', begin), text.size());
      if (end > begin) folders.emplace_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  for (const fs::path& own : own_folders()) {
    for (const char* relative : {"../lib/lucarium/techniques", "lucarium/techniques"}) {
      folders.push_back((own / relative).lexically_normal());
    }
  }
  std::vector<fs::path> unique;
  for (fs::path& folder : folders) {
    if (std::find(unique.begin(), unique.end(), folder) == unique.end()) unique.push_back(std::move(folder));
  }
  return unique;
}

TechniqueRegistry::TechniqueRegistry(const std::vector<fs::path>& extra_folders)
    : searched_(technique_folders(extra_folders)) {
  for (const fs::path& folder : extra_folders) {
    std::error_code failure;
    if (!fs::is_directory(folder, failure)) failures_.push_back({folder, "there is no such folder"});
  }
  for (const fs::path& folder : searched_) {
    std::error_code failure;
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : list_folder(folder, failure)) {
      if (entry.path().extension() == ".so") files.push_back(entry.path());
    }
    if (failure && failure != std::errc::no_such_file_or_directory && failure != std::errc::not_a_directory)
      failures_.push_back({folder, "cannot be read: " + failure.message()});
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      try {
        load(file);
      } catch (const Error& error) {
        failures_.push_back({file, error.what()});
      }
    }
  }
}

void TechniqueRegistry::load(const fs::path& file) {
  OpenLibrary library(file);
  void* symbol = ::dlsym(library.handle, "lucarium_technique");
  if (!symbol) throw_error(ErrorClass::technique, "exports no lucarium_technique() (LUCARIUM_EXPORT_TECHNIQUE)");
  TechniqueType type;
  type.file_ = file;
  type.descriptor_ = reinterpret_cast<const TechniqueDescriptor* (*)()>(symbol)();
  if (!type.descriptor_) throw_error(ErrorClass::technique, "has an empty descriptor");
  if (const std::string reason = header_mismatch(type.descriptor_->header); !reason.empty()) {
    throw_error(ErrorClass::technique, "{}", reason);
  }
  if (!type.descriptor_->info || !type.descriptor_->create)
    throw_error(ErrorClass::technique, "has an empty descriptor");
  type.info_ = call_plugin("info() failed", [&] { return type.descriptor_->info(); });
  if (!is_technique_name(type.info_.name)) {
    throw_error(ErrorClass::technique, "is named '{}'; a name consists of a-z, 0-9 and _", type.info_.name);
  }
  library.keep();
  log_info("technique {} of {}", type.info_.name, file.string());
  const bool taken = std::any_of(types_.begin(), types_.end(),
                                 [&](const TechniqueType& known) { return known.info_.name == type.info_.name; });
  if (!taken) types_.push_back(std::move(type));
}

const TechniqueType& TechniqueRegistry::find(const std::string& name) const {
  std::vector<std::string> names;
  for (const TechniqueType& type : types_) {
    if (type.info_.name == name) return type;
    names.push_back(type.info_.name);
  }
  std::string folders, reasons, all;
  for (const fs::path& folder : searched_) folders += (folders.empty() ? "" : ", ") + folder.string();
  for (const PluginFailure& failure : failures_) {
    const std::string line = fmt::format("{} {}", failure.file.string(), failure.reason);
    all += line + "\n";
    if (failure.file.stem() == name) reasons += "; " + line;
  }
  // A plug-in of that name that cannot be loaded is no mistyped name.
  const ErrorClass who = reasons.empty() ? ErrorClass::usage : ErrorClass::technique;
  if (reasons.empty()) reasons = suggest_name(name, names);
  throw Error(who, fmt::format("no technique is called '{}'{} (searched {})", name, reasons, folders))
      .with_details(all);
}

}  // namespace lucarium
