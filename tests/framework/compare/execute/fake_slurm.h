// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/text/text_values.h"
#include "test_support.h"

namespace lucarium::test {

namespace fs = std::filesystem;

/// The script stands first in PATH under the names of Slurm's commands.
class FakeSlurm {
 public:
  FakeSlurm() : path_(std::getenv("PATH")) {
    const fs::path bin = folder_.path() / "bin";
    fs::create_directories(bin);
    const fs::path script =
        fs::path(std::getenv("LUCARIUM_TEST_SOURCE")) / "tests/framework/compare/execute/fake_slurm.py";
    for (const char* name : {"sbatch", "squeue", "scancel", "sacct", "scontrol"})
      fs::create_symlink(script, bin / name);
    setenv("PATH", (bin.string() + ":" + path_).c_str(), 1);
    setenv("FAKE_SLURM", folder_.path().c_str(), 1);
  }
  ~FakeSlurm() {
    setenv("PATH", path_.c_str(), 1);
    unsetenv("FAKE_SLURM");
  }
  const fs::path& folder() const { return folder_.path(); }
  void set(const std::string& name, const std::string& text) const {
    write_file_atomically(folder_.path() / name, text + "\n");
  }
  void clear(const std::string& name) const { fs::remove(folder_.path() / name); }
  /// Lines of calls that begin so.
  std::vector<std::string> calls(const std::string& begin) const {
    std::vector<std::string> found;
    if (!fs::exists(folder_.path() / "calls.txt")) return found;
    for (const std::string& line : split(read_file(folder_.path() / "calls.txt"), '\n'))
      if (line.starts_with(begin)) found.push_back(line);
    return found;
  }

 private:
  test::TemporaryFolder folder_;
  std::string path_;
};

}  // namespace lucarium::test
