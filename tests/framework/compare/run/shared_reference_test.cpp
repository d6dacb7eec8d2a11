// SPDX-License-Identifier: Apache-2.0
// References whose rounds are shared out: what ends out of order, and interrupts on the way.
#include "lucarium/compare/run/shared_reference.h"

#include <doctest/doctest.h>

#include <cstdlib>

#include "lucarium/base/interrupt.h"
#include "lucarium/compare/execute/local_executor.h"
#include "lucarium/film/image_io.h"
#include "test_support.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

fs::path program() { return std::getenv("LUCARIUM_TEST_PROGRAM"); }

Job small_job() {
  Job job;
  job.scene = "builtin:cornell";
  job.width = job.height = 8;
  job.max_bounces = 0;
  job.seed = 5;
  PathSet paths;
  paths.max_bounces = 0;
  job.work = ReferenceWork{paths.to_string(), 0, 0, {}};
  return job;
}

/// Does the tasks of a list backwards, the first one never: an interrupt comes before.
struct Backwards : PieceExecutor {
  size_t done = 0;
  void run(const std::vector<PieceTask>& tasks, const PieceEvents& events) override {
    for (size_t i = tasks.size(); i-- > 1;) {
      LocalExecutor one(program(), {});
      PieceEvents heard = events;
      heard.on_end = [&](size_t, PieceEnd end) { events.on_end(i, std::move(end)); };
      one.run({tasks[i]}, heard);
      ++done;
    }
    set_interrupt_requested(true);
  }
  size_t width() const override { return 4; }
};

/// Says which rounds were missing.
struct Counting : PieceExecutor {
  std::vector<std::string> names;
  void run(const std::vector<PieceTask>& tasks, const PieceEvents& events) override {
    for (const PieceTask& task : tasks) names.push_back(task.name);
    LocalExecutor(program(), {}).run(tasks, events);
  }
  size_t width() const override { return 1; }
};

struct Reference {
  test::TemporaryFolder folder;
  ReferenceImage image{8, 8};
  ReferenceGoal goal;
  size_t said = 0;
  Reference() { goal.samples = 128; }
  fs::path rounds() const { return folder.path() / "rounds"; }
  bool extend(PieceExecutor& executor) {
    SharedReferenceEvents events;
    events.keep = [](ReferenceImage&, const Film&, double) {};
    events.progress = [](const ReferenceProgress&) {};
    events.say = [this](const std::string& line) { said += line.find("there already") != std::string::npos; };
    return extend_shared_reference(executor, small_job(), image, goal, rounds(), events);
  }
};

}  // namespace

TEST_CASE("rounds that had ended before the one ahead of them were lost at an interrupt") {
  Reference whole, broken;
  Counting at_once;
  REQUIRE(whole.extend(at_once));
  REQUIRE(at_once.names.size() >= 4);
  CHECK(whole.said == 0);

  Backwards backwards;
  CHECK(!broken.extend(backwards));
  set_interrupt_requested(false);
  CHECK(broken.image.samples() == 0);
  CHECK(backwards.done == at_once.names.size() - 1);
  Counting rest;
  SUBCASE("all that is missing is the first") {
    CHECK(broken.extend(rest));
    CHECK(rest.names == std::vector<std::string>{"round1"});
    CHECK(broken.said == 1);
  }
  SUBCASE("what is damaged, or another round, is rendered again") {
    fs::resize_file(broken.rounds() / "round2.exr", 100);
    fs::copy_file(broken.rounds() / "round3.exr", broken.rounds() / "round4.exr", fs::copy_options::overwrite_existing);
    CHECK(broken.extend(rest));
    CHECK(rest.names == std::vector<std::string>{"round1", "round2", "round4"});
  }
  CHECK(broken.image.film().image() == whole.image.film().image());
  CHECK(!fs::exists(broken.rounds()));
}
