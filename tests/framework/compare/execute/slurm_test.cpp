// SPDX-License-Identifier: Apache-2.0
// Comparisons whose pieces Slurm runs. Here a script plays Slurm (fake_slurm.py).
#include <doctest/doctest.h>

#include <set>
#include <thread>

#include "fake_slurm.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/execute/slurm_commands.h"
#include "lucarium/compare/execute/warm_up.h"
#include "lucarium/film/image_io.h"
#include "small_comparison.h"

using namespace lucarium;
using test::FakeSlurm;
namespace fs = std::filesystem;

namespace {

/// Four pieces.
struct SlurmComparison : test::SmallComparison {
  std::vector<std::string> lines;
  SlurmComparison() {
    spec.variants = {{"path_tracing", {}, ""}, {"path_tracing", {{"estimator", "nee"}}, ""}};
    spec.budgets = {{0, 2, 0, 0}};
    spec.seeds = 2;
    options.executor.kind = ExecutorOptions::Kind::slurm;
    options.progress = [this](const std::string& line) { lines.push_back(line); };
  }
  bool said(const std::string& part) const {
    for (const std::string& line : lines)
      if (line.find(part) != std::string::npos) return true;
    return false;
  }
};

void check_pictures(const ComparisonResult& result, const fs::path& folder, const ComparisonResult& expected,
                    const fs::path& expected_folder) {
  REQUIRE(result.pieces.size() == expected.pieces.size());
  for (size_t i = 0; i < result.pieces.size(); ++i) {
    CHECK(result.pieces[i].failure == "");
    REQUIRE(result.pieces[i].image == expected.pieces[i].image);
    CHECK(read_image(folder / result.pieces[i].image).image() ==
          read_image(expected_folder / expected.pieces[i].image).image());
  }
}

}  // namespace

TEST_CASE("Slurm and this machine give the same pictures, and nothing of Slurm is left") {
  const FakeSlurm slurm;
  SlurmComparison alone, arrays;
  alone.options.executor.kind = ExecutorOptions::Kind::local;
  arrays.options.executor.slurm = {"partition=long"};
  const ComparisonResult expected = alone.run(), got = arrays.run();
  check_pictures(got, arrays.options.folder, expected, alone.options.folder);
  const fs::path reference = got.scenes[0].references[0].image;
  CHECK(read_image(arrays.options.folder / reference).image() == read_image(alone.options.folder / reference).image());
  for (const PieceResult& piece : got.pieces) {
    REQUIRE(piece.machine);
    CHECK(piece.machine->machine == describe_machine());
    CHECK(piece.machine->other_jobs);
  }
  CHECK(!fs::exists(arrays.options.folder / "slurm"));
  const std::vector<std::string> submissions = slurm.calls("sbatch ");
  CHECK(submissions.size() == 3);  // the reference; three pieces and one, since the largest index is 3
  for (const std::string& call : submissions) {
    CHECK(call.find("--partition=long") != std::string::npos);
    CHECK(call.find("--exclusive") == std::string::npos);
  }
}

TEST_CASE("pieces whose times are compared share one task of an array, on a node of their own") {
  const FakeSlurm slurm;
  SlurmComparison comparison;
  comparison.spec.budgets = {{0.05, 0, 0, 0}};
  const ComparisonResult result = comparison.run();
  CHECK(result.pieces.size() == 4);
  size_t exclusive = 0;
  for (const std::string& call : slurm.calls("sbatch "))
    exclusive += call.find("--exclusive") != std::string::npos && call.find("--array=0-1 ") != std::string::npos;
  CHECK(exclusive == 1);  // one task per seed
}

TEST_CASE("a node that fails everything costs attempts, and no piece") {
  const FakeSlurm slurm;
  slurm.set("bad_node", "na");
  SlurmComparison comparison;
  const ComparisonResult result = comparison.run();
  REQUIRE(result.pieces.size() == 4);
  for (const PieceResult& piece : result.pieces) CHECK(piece.failure == "");
  size_t excluding = 0;
  for (const std::string& call : slurm.calls("sbatch ")) excluding += call.find("--exclude=na") != std::string::npos;
  CHECK(excluding >= 1);
}

TEST_CASE("a piece that gets lost again and again has failed, with its last words, and the others are there") {
  const FakeSlurm slurm;
  SlurmComparison comparison;
  comparison.spec.reference.samples = 32;
  ComparisonResult whole = comparison.run();  // with the reference
  REQUIRE(whole.pieces.size() == 4);
  fs::remove(comparison.options.folder / "pieces/scene1-variant2-budget1-seed2.json");
  slurm.set("lost_index", "0");
  comparison.options.resume = true;
  const ComparisonResult result = comparison.run();
  REQUIRE(result.pieces.size() == 4);
  for (const PieceResult& piece : result.pieces) {
    const bool lost = piece.variant == 1 && piece.seed == 2;
    CHECK(piece.failure.empty() != lost);
    if (lost) {
      CHECK(piece.failure.find("3 attempts: ") == 0);
      CHECK(piece.failure.find("OUT_OF_MEMORY on na: it smells of smoke here") != std::string::npos);
    }
  }
  slurm.clear("lost_index");
  CHECK(comparison.run().pieces.size() == 4);  // and --resume tries it again
  CHECK(!fs::exists(comparison.options.folder / "slurm"));
}

TEST_CASE("an interrupt leaves the jobs, and --resume attaches to them; what is finished stays") {
  const FakeSlurm slurm;
  SlurmComparison comparison;
  REQUIRE(comparison.run().pieces.size() == 4);
  const fs::path pieces = comparison.options.folder / "pieces";
  const std::string kept = read_file(pieces / "scene1-variant1-budget1-seed1.json");
  for (const char* variant : {"1", "2"})
    fs::remove(pieces / (std::string("scene1-variant") + variant + "-budget1-seed2.json"));
  comparison.options.resume = true;
  slurm.set("hold", "");
  const size_t before = slurm.calls("sbatch ").size();
  std::thread ctrl_c([&] {
    while (slurm.calls("sbatch ").size() == before) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    set_interrupt_requested(true);
  });
  const ComparisonResult broken = comparison.run();
  ctrl_c.join();
  CHECK(broken.interrupted);
  CHECK(comparison.said("2 jobs with Slurm go on; --resume attaches to them again, scancel --name=lucarium-"));
  set_interrupt_requested(false);
  slurm.clear("hold");
  const ComparisonResult whole = comparison.run();
  CHECK(!whole.interrupted);
  CHECK(whole.pieces.size() == 4);
  CHECK(comparison.said("attached to 2 jobs with Slurm"));
  CHECK(slurm.calls("sbatch ").size() == before + 1);
  CHECK(read_file(pieces / "scene1-variant1-budget1-seed1.json") == kept);
}

TEST_CASE("what Slurm refuses at once is an error in its words; a controller that is silent is waited for") {
  const FakeSlurm slurm;
  SlurmComparison comparison;
  slurm.set("refuse", "invalid partition specified: lnog");
  CHECK_THROWS_WITH_AS(comparison.run(),
                       "Slurm does not take the jobs: sbatch: error: invalid partition specified: lnog", Error);
  slurm.clear("refuse");
  comparison.options.resume = true;
  slurm.set("silent", "");
  const auto hear = comparison.options.progress;
  comparison.options.progress = [&](const std::string& line) {
    hear(line);
    if (line.find("squeue does not answer") != std::string::npos) slurm.clear("silent");
  };
  CHECK(comparison.run().pieces.size() == 4);
}

TEST_CASE("a completed job whose files a shared folder showed late was lost") {
  const FakeSlurm slurm;
  SlurmComparison comparison;
  comparison.spec.variants.resize(1);
  comparison.spec.seeds = 1;
  comparison.options.executor.kind = ExecutorOptions::Kind::local;
  REQUIRE(comparison.run().pieces.size() == 1);
  fs::remove(comparison.options.folder / "pieces/scene1-variant1-budget1-seed1.json");
  comparison.options.executor.kind = ExecutorOptions::Kind::slurm;
  comparison.options.resume = true;
  slurm.set("early", "3");  // looks at the queue
  const ComparisonResult result = comparison.run();
  REQUIRE(result.pieces.size() == 1);
  CHECK(result.pieces[0].failure == "");
  CHECK(slurm.calls("sbatch ").size() == 1);  // nothing again
}

TEST_CASE("options of sbatch that the program sets are refused") {
  CHECK_NOTHROW(check_slurm_options({"partition=long", "time=1:00:00", "exclusive"}));
  CHECK_THROWS_AS(check_slurm_options({"array=1-7"}), Error);
  CHECK_THROWS_AS(check_slurm_options({"--partition=long"}), Error);
}

TEST_CASE("kernels are compiled by the first of many tasks, once per kind of job") {
  const test::TemporaryFolder folder;
  const fs::path program = folder.path() / "program", runs = folder.path() / "runs";
  write_file_atomically(program, "#!/bin/sh\ncat > /dev/null\nsleep 0.2\necho run >> " + runs.string() + "\n");
  fs::permissions(program, fs::perms::owner_all);
  Job job;
  job.scene = "builtin:cornell";
  RenderWork work;
  work.technique = "path_tracing";
  work.iterations = 7;
  job.work = work;
  Job other = job;
  other.seed = 5;
  std::get<RenderWork>(other.work).output = "elsewhere.exr";
  std::get<RenderWork>(other.work).iterations = 9;
  const fs::path warm = folder.path() / "warm";
  CHECK(warm_up_text(job, warm) == warm_up_text(other, warm));
  std::vector<std::thread> tasks;
  for (int i = 0; i < 8; ++i) tasks.emplace_back([&] { warm_up(program, warm_up_text(job, warm), warm); });
  for (std::thread& task : tasks) task.join();
  CHECK(read_file(runs) == "run\n");
  std::get<RenderWork>(job.work).technique = "voxel_abuffer";
  warm_up(program, warm_up_text(job, warm), warm);
  CHECK(read_file(runs) == "run\nrun\n");
}
