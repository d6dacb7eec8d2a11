// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace lucarium::test {

/// Whether the long statistics were asked for (CTest label `full`).
bool full_run();

/// The folder of third-party scenes, or empty when it is absent. Tests that need it call
/// `if (shared_scenes().empty()) return skip("third-party scenes");`.
std::filesystem::path shared_scenes();

/// Reports a visible skip: prints a line and, when every test case of the run was skipped, makes the program exit
/// with 77, which CTest shows as "Skipped".
void skip(const std::string& what_is_missing);

/// A fresh empty folder, removed when the object goes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Outcome of a program run to its end.
struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string out;
  std::string err;
};

/// Runs a shell command line and captures both streams. `timeout_seconds` kills it.
ProgramResult run_program(const std::string& command, double timeout_seconds = 300);

/// The built command-line program (quoted for a shell).
std::string lucarium_program();

}  // namespace lucarium::test
