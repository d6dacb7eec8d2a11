// SPDX-License-Identifier: Apache-2.0
#include "outputs/output_files.h"

#include <unistd.h>

#include <map>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"

namespace lucarium::app {
namespace fs = std::filesystem;

void check_image_name(const fs::path& file) {
  if (file.extension() != ".exr" && file.extension() != ".png")
    throw_error(ErrorClass::usage, "{}: the name must end in .exr or .png", file.string());
}

void check_output(const fs::path& file, bool overwrite) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) throw_error(ErrorClass::usage, "{} is a folder, not a file", file.string());
  // The new file takes the place of what is there: of /dev/null, too.
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored))
    throw_error(ErrorClass::usage, "{} is a pipe, a device or the like, not a file; choose another name",
                file.string());
  if (fs::exists(file, ignored) && !overwrite) {
    throw_error(ErrorClass::usage, "{} exists; choose another name or give --overwrite", file.string());
  }
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) {
    throw_error(ErrorClass::usage, "{}: there is no folder {} to write into", file.string(), folder.string());
  }
  const fs::path probe = folder / fmt::format(".lucarium-probe-{}", ::getpid());
  try {
    write_file_atomically(probe, "");
  } catch (const Error& error) {
    throw Error(ErrorClass::input,
                fmt::format("{}: the folder {} cannot be written into", file.string(), folder.string()))
        .with_details(error.what());
  }
  fs::remove(probe, ignored);
}

void check_distinct(const std::vector<fs::path>& files) {
  std::map<fs::path, fs::path> known;
  for (const fs::path& file : files) {
    std::error_code failure;
    const fs::path real = fs::weakly_canonical(fs::absolute(file, failure), failure);
    const auto [earlier, is_new] = known.emplace(failure ? file.lexically_normal() : real, file);
    if (is_new) continue;
    throw_error(ErrorClass::usage, "{} and {} are the same file; give every output a name of its own",
                earlier->second.string(), file.string());
  }
}

}  // namespace lucarium::app
