// SPDX-License-Identifier: Apache-2.0
// Pieces and the rounds of a reference shared out between two drivers that have nothing in common: PoCL and, where
// tools/drivers/intel.sh has put it into build/drivers/intel, Intel's runtime for CPUs. Their pixels agree up to the
// rounding of floats: each operation is off by some 1e-7 of its value, and a light path has some hundred of them; where
// none takes another turn, the sum is far below 1e-5 of a pixel, a relMSE of 1e-10.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cstdlib>
#include <set>

#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/metrics.h"
#include "scoped_variable.h"
#include "small_comparison.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

constexpr double rounding = 1e-10;  // relMSE

/// The shell commands by which programs see both drivers; empty where there are not both.
std::string use_both() {
  const fs::path source = std::getenv("LUCARIUM_TEST_SOURCE"), folder = source / "build/drivers/intel";
  if (!fs::exists(folder / "installed.txt") || !fs::exists("/etc/OpenCL/vendors/pocl.icd")) return "";
  return fmt::format("eval \"$('{}/tools/drivers/intel.sh' '{}' --beside-pocl)\"; ", source.string(), folder.string());
}

std::string value_of(const std::string& variable) {
  const test::ProgramResult shell = test::run_program(use_both() + "printf %s \"$" + variable + "\"");
  REQUIRE_MESSAGE(shell.exit_code == 0, shell.err);
  return shell.out;
}

/// How far the picture is from the other one.
double difference(const Film& film, const Film& other) {
  REQUIRE(film.pixel_count() == other.pixel_count());
  return MetricReference(film.width(), film.height(), other.image(), {0, false}).measure(film.image()).relmse;
}

}  // namespace

TEST_CASE("PoCL and Intel's driver share a comparison, and their pixels agree up to rounding") {
  if (use_both().empty()) return test::skip("Intel's OpenCL runtime in build/drivers/intel, or PoCL");
  test::SmallComparison alone, shared;
  for (test::SmallComparison* comparison : {&alone, &shared}) {
    comparison->spec.variants = {{"path_tracing", {}, ""}, {"path_tracing", {{"estimator", "nee"}}, ""}};
    comparison->spec.budgets = {{0, 2, 0, 0}};
    comparison->spec.seeds = 4;
    comparison->spec.width = comparison->spec.height = 16;
    comparison->spec.max_bounces = 2;
  }
  const ComparisonResult expected = alone.run();
  const test::ScopedVariable vendors("OCL_ICD_VENDORS", value_of("OCL_ICD_VENDORS"));
  const test::ScopedVariable libraries("LD_LIBRARY_PATH", value_of("LD_LIBRARY_PATH"));
  shared.options.executor.devices = {"Portable", "Intel"};
  const ComparisonResult got = shared.run();
  REQUIRE(expected.pieces.size() == 8);
  REQUIRE(got.pieces.size() == 8);
  std::set<std::string> devices;
  for (size_t i = 0; i < got.pieces.size(); ++i) {
    const PieceResult &a = expected.pieces[i], &b = got.pieces[i];
    CHECK(b.failure == "");
    REQUIRE(a.image == b.image);
    devices.insert(b.device);
    CHECK(difference(read_image(shared.options.folder / b.image), read_image(alone.options.folder / a.image)) <
          rounding);
    CHECK(b.processor_seconds.value() > 0);
  }
  CHECK(devices.size() == 2);
  CHECK(got.scenes[0].unlike_machines);
  CHECK(!expected.scenes[0].unlike_machines);
  for (const auto& [key, summary] : got.summaries) {
    CHECK(summary.times.empty());
    CHECK(!summary.processor_curve.empty());
  }
}

TEST_CASE("PoCL and Intel's driver share the rounds of a reference") {
  if (use_both().empty()) return test::skip("Intel's OpenCL runtime in build/drivers/intel, or PoCL");
  const test::TemporaryFolder folder;
  const fs::path alone = folder.path() / "alone.exr", shared = folder.path() / "shared.exr";
  const auto reference = [](const fs::path& file, const std::string& more) {
    return fmt::format("{} reference builtin:cornell --size 16x16 --max-bounces 2 --spp 192 -q -o {} {}",
                       test::lucarium_program(), file.string(), more);
  };
  REQUIRE(test::run_program(reference(alone, "--device Portable")).exit_code == 0);
  const test::ProgramResult run = test::run_program(use_both() + reference(shared, "--devices all"));
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  const Film one = read_image(alone), other = read_image(shared);
  CHECK(difference(other, one) < rounding);
  for (const char* key : {"samples", "half_a_samples", "half_b_samples", "rounds"})
    CHECK(one.metadata.at(key) == other.metadata.at(key));
}
