// SPDX-License-Identifier: Apache-2.0
// Comparisons that are interrupted, at moments that their own lines mark, and resumed; the runs are processes of the
// program.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <atomic>
#include <fstream>
#include <future>
#include <optional>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/files/file_state.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/stopwatch.h"
#include "small_comparison.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

/// The class of the error with which a comparison ends.
ErrorClass end_of(const test::SmallComparison& comparison) {
  try {
    comparison.run();
  } catch (const Error& error) {
    return error.error_class();
  }
  FAIL("it ended without an error");
  return ErrorClass::internal;
}

fs::path cached_reference(const test::SmallComparison& comparison) {
  fs::path cached;
  for (const fs::directory_entry& entry : fs::directory_iterator(comparison.options.cache_dir / "references"))
    if (entry.path().extension() == ".exr") cached = entry.path();
  REQUIRE(!cached.empty());
  return cached;
}

}  // namespace

TEST_CASE("Ctrl-C between two experiments that replace results deleted those of the next one") {
  test::SmallComparison comparison;
  REQUIRE(comparison.run().pieces.size() == 1);
  const std::string before = comparison.results();
  comparison.options.overwrite = true;
  set_interrupt_requested(true);  // while the experiment before it ended
  CHECK(end_of(comparison) == ErrorClass::interrupted);
  CHECK(comparison.results() == before);
  CHECK(fs::exists(comparison.options.folder / "pieces/scene1-variant1-budget1-seed1.exr"));
}

TEST_CASE("Ctrl-C while a resumed comparison renders a reference ended it with an error about a missing image") {
  test::SmallComparison comparison;
  comparison.spec.seeds = 2;  // so that a bias is measured against the reference
  REQUIRE(comparison.run().pieces.size() == 2);
  const std::string before = comparison.results();
  fs::remove(comparison.options.folder / "references/scene1-set1.exr");
  fs::remove_all(comparison.options.cache_dir / "references");
  comparison.options.resume = true;
  comparison.options.progress = [](const std::string& line) {
    if (line.find("reference 1 of 1") != std::string::npos) set_interrupt_requested(true);
  };
  CHECK(comparison.run().interrupted);
  CHECK(comparison.results() == before);

  set_interrupt_requested(false);
  comparison.options.progress = {};
  const ComparisonResult resumed = comparison.run();
  CHECK(!resumed.interrupted);
  CHECK(resumed.pieces.size() == 2);
}

TEST_CASE("a damaged reference in the cache was removed although another run had replaced it, without its lock") {
  test::SmallComparison comparison;
  REQUIRE(comparison.run().pieces.size() == 1);
  const fs::path cached = cached_reference(comparison);
  const std::string whole = read_file(cached);
  write_file_atomically(cached, "damaged");
  fs::remove_all(comparison.options.folder);
  FileState replaced;
  std::atomic<bool> waited = false;
  std::thread other;
  comparison.options.progress = [&](const std::string& line) {
    if (line.find("waiting for another run") != std::string::npos) waited = true;
    if (line.find("the cached reference is not usable") == std::string::npos || other.joinable()) return;
    std::promise<void> locked;
    other = std::thread([&] {
      const FileLock lock(cached.string() + ".lock", [] {});
      locked.set_value();
      const Stopwatch patience;
      while (!waited && patience.seconds() < 60) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      CHECK(waited);
      CHECK(read_file(cached) == "damaged");
      write_file_atomically(cached, whole);
      replaced = FileState(cached);
    });
    locked.get_future().wait();
  };
  const ComparisonResult result = comparison.run();
  REQUIRE(other.joinable());
  other.join();
  CHECK(result.scenes[0].references[0].failure == "");
  CHECK(FileState(cached) == replaced);
}

TEST_CASE("Ctrl-C while a damaged reference waits for another run's lock ended the comparison with an error") {
  test::SmallComparison comparison;
  REQUIRE(comparison.run().pieces.size() == 1);
  const fs::path cached = cached_reference(comparison);
  write_file_atomically(cached, "damaged");
  fs::remove_all(comparison.options.folder);
  std::optional<FileLock> other;
  bool waited = false;
  comparison.options.progress = [&](const std::string& line) {
    if (line.find("the cached reference is not usable") != std::string::npos)
      other.emplace(cached.string() + ".lock", [] {});
    if (!other || line.find("waiting for another run") == std::string::npos) return;
    waited = true;
    set_interrupt_requested(true);
  };
  CHECK(comparison.run().interrupted);
  CHECK(waited);
  CHECK(read_file(cached) == "damaged");
  set_interrupt_requested(false);
}

TEST_CASE("a comparison that is interrupted while it plans left an empty folder with a lock") {
  test::SmallComparison comparison;
  comparison.spec.scenes.resize(2);
  comparison.spec.scenes[1].source = "/nonexistent.glb";  // reported in the middle of planning
  bool reported = false;
  comparison.options.progress = [&](const std::string& line) {
    if (line.find("/nonexistent.glb") == std::string::npos || reported) return;
    reported = true;
    CHECK(!fs::exists(comparison.options.folder));
    set_interrupt_requested(true);
  };
  CHECK(end_of(comparison) == ErrorClass::interrupted);
  CHECK(reported);
  CHECK(!fs::exists(comparison.options.folder));
}

TEST_CASE("a comparison resumed on another machine mixed seeds whose parameters had been planned differently") {
  test::SmallComparison comparison;
  comparison.spec.seeds = 3;
  const ComparisonResult first = comparison.run();
  REQUIRE(first.pieces.size() == 3);
  const auto summary = [&](int seed) {
    return comparison.options.folder / fmt::format("pieces/scene1-variant1-budget1-seed{}.json", seed);
  };
  const auto plan_otherwise = [&](int seed) {
    nlohmann::json json = nlohmann::json::parse(read_file(summary(seed)));
    json["parameters"] = "planned elsewhere";
    json["planned"] = "points 2 -> 1";
    write_file_atomically(summary(seed), json.dump(1));
  };
  int reported = 0;
  comparison.options.resume = true;
  comparison.options.progress = [&](const std::string& line) {
    reported += line.find("rendered with other parameters (planned elsewhere) than seed") != std::string::npos;
  };
  const auto check_resumed = [&] {
    const ComparisonResult resumed = comparison.run();
    REQUIRE(resumed.pieces.size() == 3);
    for (size_t i = 0; i < 3; ++i) {
      CHECK(resumed.pieces[i].seed == i + 1);
      CHECK(resumed.pieces[i].parameters == first.pieces[i].parameters);
      CHECK(resumed.pieces[i].metrics == first.pieces[i].metrics);
    }
    CHECK(resumed.scenes[0].warnings == first.scenes[0].warnings);
    CHECK(comparison.results().find("planned elsewhere") == std::string::npos);
  };

  SUBCASE("the seeds that were missing are rendered here, and then the others again") {
    plan_otherwise(1);
    plan_otherwise(2);
    fs::remove(summary(3));
    check_resumed();
    CHECK(reported == 2);
  }
  SUBCASE("all seeds are there, but not alike") {
    plan_otherwise(1);
    check_resumed();
    CHECK(reported == 1);
  }
}
