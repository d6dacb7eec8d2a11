// SPDX-License-Identifier: Apache-2.0
// lucarium reference and reproduce with --executor slurm, which a script plays (fake_slurm.py): the pixels are those of
// this machine.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include "fake_slurm.h"
#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"

using namespace lucarium;
using test::FakeSlurm;
namespace fs = std::filesystem;

namespace {

std::string program() { return std::getenv("LUCARIUM_TEST_PROGRAM"); }

std::string reference(const fs::path& file, const std::string& more) {
  return fmt::format("{} reference builtin:cornell --size 8x8 --max-bounces 0 -o {} {}", program(), file.string(),
                     more);
}

void check_same(const fs::path& a, const fs::path& b) {
  const Film one = read_image(a), other = read_image(b);
  CHECK(one.image() == other.image());
  for (const char* key : {"samples", "half_a_samples", "own_relmse"})
    CHECK(one.metadata.at(key) == other.metadata.at(key));
}

/// A paper of one experiment with a budget of iterations.
void write_paper(const fs::path& folder) {
  const fs::path paper = folder / "experiments/author2026";
  fs::create_directories(paper);
  write_file_atomically(paper / "paper.json", R"({"schema": "lucarium-paper-1", "citation": "Author 2026",
    "technique": "path_tracing", "experiments": ["errors"]})");
  write_file_atomically(paper / "errors.json", R"({"schema": "lucarium-experiment-1", "title": "Errors",
    "place": "Table 1", "claim": "None.",
    "comparison": {"scenes": ["builtin:cornell"], "techniques": ["path_tracing",
        {"technique": "path_tracing", "parameters": {"estimator": "nee"}, "name": "nee"}],
      "budgets": [{"iterations": 2}], "seeds": 2, "size": [8, 8], "max_bounces": 0, "reference": {"samples": 32}},
    "quick": {"seeds": 1},
    "values": [{"name": "error", "technique": "nee", "value": "relMSE"}],
    "trends": [{"claim": "there is one", "holds": "error > 0"}]})");
}

}  // namespace

TEST_CASE("reference: rounds that Slurm runs give the file of this machine, to a number of samples and to an error") {
  const FakeSlurm slurm;
  const test::TemporaryFolder folder;
  const fs::path alone = folder.path() / "alone.exr", arrays = folder.path() / "arrays.exr";
  for (const std::string goal : {"--spp 96", "--relmse 0.01"}) {
    CAPTURE(goal);
    REQUIRE(test::run_program(reference(alone, goal + " -q --overwrite")).exit_code == 0);
    const size_t before = slurm.calls("sbatch ").size();
    const test::ProgramResult run =
        test::run_program(reference(arrays, goal + " -q --overwrite --executor slurm --slurm partition=long"));
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    CHECK(slurm.calls("sbatch ").size() > before);
    for (const std::string& call : slurm.calls("sbatch ")) CHECK(call.find("--partition=long") != std::string::npos);
    check_same(alone, arrays);
    CHECK(!fs::exists(arrays.string() + ".rounds"));
  }
}

TEST_CASE("reference: an interrupt leaves its rounds with Slurm, and --extend attaches to them") {
  const FakeSlurm slurm;
  const test::TemporaryFolder folder;
  const fs::path alone = folder.path() / "alone.exr", arrays = folder.path() / "arrays.exr";
  REQUIRE(test::run_program(reference(alone, "-q --spp 64")).exit_code == 0);
  REQUIRE(test::run_program(reference(arrays, "-q --spp 32 --executor slurm")).exit_code == 0);
  const size_t before = slurm.calls("sbatch ").size();
  slurm.set("hold", "");
  const std::string more = reference(arrays, "--spp 64 --extend --executor slurm");
  // Until the program asks how the new array does: then it knows that Slurm has taken it.
  const std::string asked =
      fmt::format("awk '/^sbatch /{{++arrays}} /^squeue / && arrays > {}{{asked = 1}} END{{exit !asked}}' {}", before,
                  (slurm.folder() / "calls.txt").string());
  const test::ProgramResult broken = test::run_program(fmt::format(
      "{} & pid=$!; until {}; do kill -0 $pid || exit 99; sleep 0.05; done; kill -TERM $pid; wait $pid", more, asked));
  CHECK_MESSAGE(broken.exit_code == 6, broken.err);
  CHECK(broken.err.find("go on; --extend attaches to them again") != std::string::npos);
  const size_t submitted = slurm.calls("sbatch ").size();
  slurm.clear("hold");
  const test::ProgramResult whole = test::run_program(more);
  CHECK_MESSAGE(whole.exit_code == 0, whole.err);
  CHECK(whole.err.find("attached to") != std::string::npos);
  CHECK(slurm.calls("sbatch ").size() == submitted);
  check_same(alone, arrays);
  CHECK(!fs::exists(arrays.string() + ".rounds"));
}

TEST_CASE("reproduce: an experiment that Slurm runs has the pixels of this machine") {
  const FakeSlurm slurm;
  const test::TemporaryFolder folder;
  write_paper(folder.path());
  const auto reproduce = [&](const std::string& name, const std::string& more) {
    const test::ProgramResult run = test::run_program(fmt::format(
        "{0} reproduce author2026/errors --full --technique-path {1} --cache-dir {1}/cache{2} -o {1}/{2} {3}",
        program(), folder.path().string(), name, more));
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    return folder.path() / name / "errors";
  };
  const fs::path alone = reproduce("alone", ""), arrays = reproduce("arrays", "--executor slurm");
  CHECK(slurm.calls("sbatch ").size() >= 2);  // the reference, and pieces
  size_t images = 0;
  for (const char* kind : {"pieces", "references", "means"}) {
    for (const fs::directory_entry& entry : fs::directory_iterator(alone / kind)) {
      if (entry.path().extension() != ".exr") continue;
      ++images;
      CHECK(read_image(entry.path()).image() == read_image(arrays / kind / entry.path().filename()).image());
    }
  }
  CHECK(images == 4 + 1 + 2);
  const auto verdict = [](const fs::path& results) {
    return nlohmann::json::parse(read_file(results / "results.json"))["reproduction"]["trends"][0]["verdict"];
  };
  CHECK(verdict(alone) == "holds");
  CHECK(verdict(arrays) == "holds");
  CHECK(!fs::exists(arrays / "slurm"));
}
