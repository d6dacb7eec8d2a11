// SPDX-License-Identifier: Apache-2.0
// What the tests of the command line share.
#pragma once
#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "lucarium/base/json.h"
#include "test_support.h"

namespace lucarium::test {

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline std::string environment(const char* name) {
  const char* value = std::getenv(name);
  REQUIRE_MESSAGE(value, name);
  return value;
}

/// Arguments that choose the technique `constant`, whose image is known, at a small size.
inline std::string constant_technique(const std::string& parameters = "") {
  return "--technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/constant -t constant" +
         (parameters.empty() ? "" : ":" + parameters) + " --max-bounces 1 --size 16x8 ";
}

inline ProgramResult run_lucarium(const std::string& arguments) {
  return run_program(lucarium_program() + " " + arguments);
}

/// What `lucarium render --json` says about its one frame.
inline nlohmann::json only_frame(const ProgramResult& result) {
  CAPTURE(result.err);
  const nlohmann::json frames = nlohmann::json::parse(result.out).at("frames");
  REQUIRE(frames.size() == 1);
  return frames[0];
}

/// The run ended with that code and exactly one line of error that contains `part`.
inline void check_refused(const std::string& arguments, int exit_code, const std::string& part) {
  const ProgramResult result = run_lucarium(arguments);
  CAPTURE(arguments);
  CAPTURE(result.err);
  CHECK(result.exit_code == exit_code);
  CHECK(result.out.empty());
  const size_t at = result.err.find("lucarium: error: ");
  REQUIRE(at != std::string::npos);
  CHECK(contains(result.err, part));
  CHECK(result.err.find('\n', at) == result.err.size() - 1);
  CHECK(result.err.find("lucarium: error: ", at + 1) == std::string::npos);
}

/// Asks again and again whether something holds, for a minute at most: a busy machine is slow, not wrong.
inline bool wait_until(const std::function<bool()>& holds) {
  constexpr std::chrono::seconds patience{60};
  for (const auto start = std::chrono::steady_clock::now(); !holds();) {
    if (std::chrono::steady_clock::now() - start > patience) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

inline size_t count_files(const std::filesystem::path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace lucarium::test
