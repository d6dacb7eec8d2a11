// SPDX-License-Identifier: Apache-2.0
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "test_support.h"

namespace {

int skipped_cases = 0;

/// Counts the test cases that ran, so that a filter that matches nothing cannot pass.
struct CaseCounter : doctest::IReporter {
  explicit CaseCounter(const doctest::ContextOptions&) {}
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats& stats) override {
    ran = static_cast<int>(stats.numTestCasesPassingFilters);
  }
  void test_case_start(const doctest::TestCaseData&) override {}
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_end(const doctest::CurrentTestCaseStats&) override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}
  static inline int ran = 0;
};
REGISTER_LISTENER("case_counter", 1, CaseCounter);

std::string read_all(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

namespace lucarium::test {

bool full_run() {
  const char* value = std::getenv("LUCARIUM_TEST_FULL");
  return value && std::string(value) == "1";
}

std::filesystem::path shared_scenes() {
  const char* root = std::getenv("LUCARIUM_TEST_SHARED");
  const std::filesystem::path folder = std::filesystem::path(root ? root : "../shared") / "scenes";
  std::error_code ignored;
  return std::filesystem::is_directory(folder, ignored) ? std::filesystem::canonical(folder) : std::filesystem::path();
}

void skip(const std::string& what_is_missing) {
  ++skipped_cases;
  std::printf("SKIPPED: %s not available\n", what_is_missing.c_str());
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "lucarium-test-XXXXXX").string();
  if (!mkdtemp(pattern.data())) throw std::runtime_error("cannot create a temporary folder");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

ProgramResult run_program(const std::string& command, double timeout_seconds) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string(), err = (folder.path() / "err").string();
  const std::string line = "timeout " + std::to_string(timeout_seconds) + " sh -c '" +
                           [&] {
                             std::string quoted;
                             for (const char c : command)
                               quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
                             return quoted;
                           }() +
                           "' >" + out + " 2>" + err + " </dev/null";
  const int status = std::system(line.c_str());
  ProgramResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = read_all(out);
  result.err = read_all(err);
  return result;
}

std::string lucarium_program() {
  const char* path = std::getenv("LUCARIUM_TEST_PROGRAM");
  return std::string("'") + (path ? path : "lucarium") + "'";
}

}  // namespace lucarium::test

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  const int result = context.run();
  if (context.shouldExit()) return result;
  if (CaseCounter::ran == 0) {
    std::puts("no test case matched the filter");
    return 1;
  }
  if (result == 0 && skipped_cases == CaseCounter::ran) return 77;
  return result;
}
