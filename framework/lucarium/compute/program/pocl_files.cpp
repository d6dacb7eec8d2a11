// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/pocl_files.h"

#include <fstream>
#include <map>
#include <mutex>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/compute/device/pocl_folder.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr const char* launch_code = ".so";
constexpr const char* intermediate_code = "program.bc";

std::mutex& folder_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// Writes a file that appears whole or not at all; without synchronising, since the folder does not outlive us.
void write_new_file(const fs::path& path, const std::string& bytes) {
  if (fs::exists(path)) return;
  fs::create_directories(path.parent_path());
  const fs::path temporary = path.string() + ".part";
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
      std::error_code ignored;
      fs::remove(temporary, ignored);
      throw_error(ErrorClass::device, "{} cannot be written", path.string());
    }
  }
  fs::rename(temporary, path);
}

fs::path generic_variant(const std::string& program, const std::string& kernel) {
  return driver_folder()->path() / program / kernel / "0-0-0" / (kernel + launch_code);
}

/// Program by cache key, as known to this process. Under folder_mutex().
std::string& program_of(const Hash128& key) {
  static std::map<std::string, std::string> programs;
  return programs[key.hex()];
}

bool stays_inside(const fs::path& relative) {
  return relative.is_relative() && !relative.empty() && *relative.lexically_normal().begin() != "..";
}

}  // namespace

std::string program_made_by(const Hash128& key, const std::function<void()>& build) {
  const std::lock_guard lock(folder_mutex());
  const std::vector<std::string> before = driver_folder()->programs();
  build();
  const std::set<std::string> known(before.begin(), before.end());
  std::vector<std::string> made = driver_folder()->programs();
  std::erase_if(made, [&](const std::string& program) { return known.contains(program); });
  if (made.size() == 1) program_of(key) = made.front();
  return program_of(key);
}

bool has_launch_code(const std::string& program, const std::string& kernel, const std::array<size_t, 3>& local,
                     bool is_large) {
  const std::string variant =
      fmt::format("{}-{}-{}-goffs0{}", local[0], local[1], local[2], is_large ? "" : "-smallgrid");
  std::error_code failure;
  return fs::exists(driver_folder()->path() / program / kernel / variant / (kernel + launch_code), failure);
}

fs::path write_source(const Hash128& key, const std::string& source) {
  fs::path file = driver_folder()->path() / "sources" / (key.hex() + ".cl");
  write_new_file(file, source);
  return file;
}

std::set<std::string> list_driver_files(const std::string& program) {
  std::set<std::string> paths;
  const fs::path& root = driver_folder()->path();
  std::error_code failure;
  for (fs::recursive_directory_iterator entry(root / program, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    const fs::path& path = entry->path();
    if (path.extension() != launch_code && path.filename() != intermediate_code) continue;
    std::error_code gone;
    const bool empty = !entry->is_regular_file(gone) || entry->file_size(gone) == 0;
    if (!empty && !gone) paths.insert(path.lexically_relative(root).string());
  }
  return paths;
}

std::vector<DriverFile> read_driver_files(const std::set<std::string>& paths) {
  std::vector<DriverFile> files;
  for (const std::string& path : paths) files.push_back({path, read_file(driver_folder()->path() / path)});
  return files;
}

void restore_driver_files(const Hash128& key, const CachedProgram& program) {
  const std::lock_guard lock(folder_mutex());
  program_of(key) = program.driver_program;
  const fs::path& root = driver_folder()->path();
  for (const DriverFile& file : program.driver_files) {
    if (!stays_inside(file.path)) throw_error(ErrorClass::device, "driver file '{}' is outside the folder", file.path);
    write_new_file(root / file.path, file.bytes);
  }
  if (program.binary.empty()) return;
  // PoCL unpacks only what is not there: the stand-ins inside the binary must never become files again.
  for (const KernelSignature& kernel : program.signatures)
    write_new_file(generic_variant(program.driver_program, kernel.name), "");
}

void without_generic_variants(const std::string& program, const std::vector<std::string>& kernels,
                              const std::function<void()>& take) {
  const std::lock_guard lock(folder_mutex());
  std::map<fs::path, fs::path> stand_ins;
  for (const std::string& path : list_driver_files(program)) {
    const fs::path file = driver_folder()->path() / path;
    if (file.extension() == launch_code) stand_ins.emplace(generic_variant(program, file.stem().string()), file);
  }
  for (const std::string& kernel : kernels) {
    if (!stand_ins.contains(generic_variant(program, kernel))) return;
  }
  const auto remove = [&] {
    std::error_code ignored;
    for (const auto& [generic, code] : stand_ins) fs::remove(generic, ignored);
  };
  try {
    remove();  // the empty files of an earlier restore
    for (const auto& [generic, code] : stand_ins) write_new_file(generic, read_file(code));
    take();
  } catch (...) {
    remove();
    throw;
  }
  remove();
}

}  // namespace lucarium
