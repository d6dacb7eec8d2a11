// SPDX-License-Identifier: Apache-2.0
// Pieces and references shared out between devices; PoCL lends two.
#include <doctest/doctest.h>

#include <cstdlib>

#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"
#include "small_comparison.h"
#include "two_devices.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

/// Children of this process see two devices of PoCL.
struct TwoDevices {
  TwoDevices() { setenv("POCL_DEVICES", test::two_devices_of_pocl, 1); }
  ~TwoDevices() { unsetenv("POCL_DEVICES"); }
};

/// Two techniques with different light paths, four seeds.
struct SharedComparison : test::SmallComparison {
  SharedComparison() {
    spec.variants = {{"path_tracing", {}, ""}, {"path_tracing", {{"environment", "off"}}, ""}};
    spec.scenes[0].overrides.environment = "0.5,0.6,0.7";
    spec.budgets = {{0, 2, 0, 0}};
    spec.seeds = 4;
  }
};

std::vector<float> picture(const fs::path& folder, const std::string& name) {
  return read_image(folder / name).image();
}

}  // namespace

TEST_CASE("two devices do every piece and reference once, with the pixels of one device") {
  if (!test::lends_two_devices()) return test::skip("PoCL, which lends two devices");
  const TwoDevices two;
  const SharedComparison alone;
  SharedComparison shared;
  shared.options.executor.devices = {"0", "1"};
  const ComparisonResult expected = alone.run(), got = shared.run();
  REQUIRE(got.pieces.size() == 8);
  REQUIRE(expected.pieces.size() == 8);
  std::map<std::string, size_t> done;
  for (size_t i = 0; i < got.pieces.size(); ++i) {
    const PieceResult &a = expected.pieces[i], &b = got.pieces[i];
    CHECK(b.failure == "");
    REQUIRE(a.image == b.image);
    CHECK(picture(alone.options.folder, a.image) == picture(shared.options.folder, b.image));
    REQUIRE(b.machine);
    ++done[b.machine->device_index];
    const nlohmann::json summary =
        nlohmann::json::parse(read_file((shared.options.folder / b.image).replace_extension(".json")));
    CHECK(summary["machine"]["device_index"] == b.machine->device_index);
    CHECK(!a.machine->device_index.size());
  }
  CHECK(done.size() == 2);
  REQUIRE(got.scenes[0].references.size() == 2);
  for (const ReferenceResult& reference : got.scenes[0].references)
    CHECK(picture(alone.options.folder, reference.image) == picture(shared.options.folder, reference.image));
}

TEST_CASE("a device that fails every piece loses none") {
  if (!test::lends_two_devices()) return test::skip("PoCL, which lends two devices");
  const TwoDevices two;
  SharedComparison comparison;
  comparison.options.executor.devices = {"7", "1"};  // there is no device 7
  size_t tried_again = 0, aside = 0;
  comparison.options.progress = [&](const std::string& line) {
    tried_again += line.find("device 7") != std::string::npos && line.find("trying another") != std::string::npos;
    aside += line.find("device 7 gets nothing more") != std::string::npos;
  };
  const ComparisonResult result = comparison.run();
  CHECK(result.pieces.size() == 8);
  for (const PieceResult& piece : result.pieces) {
    CHECK(piece.failure == "");
    CHECK(piece.machine->device_index == "1");
  }
  CHECK(tried_again >= 1);
  CHECK(aside <= 2);  // once for the references, once for the pieces
}

TEST_CASE("where every device fails a piece, the piece has failed and the others go on") {
  if (!test::lends_two_devices()) return test::skip("PoCL, which lends two devices");
  const TwoDevices two;
  SharedComparison comparison;
  const fs::path plugins = fs::path(std::getenv("LUCARIUM_TEST_PLUGINS")) / "constant";
  const TechniqueRegistry registry({plugins});
  comparison.options.technique_folders = {plugins};
  comparison.options.executor.devices = {"0", "1"};
  comparison.spec.variants[1] = {"constant", {{"failure", "error"}, {"fail_at", "1"}}, ""};
  const ComparisonResult result = run_comparison(comparison.spec, registry, comparison.options);
  REQUIRE(result.pieces.size() == 8);
  for (const PieceResult& piece : result.pieces) CHECK(piece.failure.empty() == (piece.variant == 0));
}

TEST_CASE("an interrupt ends the pieces on all devices, and what is finished stays") {
  if (!test::lends_two_devices()) return test::skip("PoCL, which lends two devices");
  const TwoDevices two;
  SharedComparison comparison;
  comparison.spec.seeds = 8;
  comparison.options.executor.devices = {"0", "1"};
  comparison.options.progress = [](const std::string& line) {
    if (line.starts_with("[3/")) set_interrupt_requested(true);
  };
  const ComparisonResult broken = comparison.run();
  CHECK(broken.interrupted);
  CHECK(broken.pieces.size() >= 3);
  CHECK(broken.pieces.size() < 16);
  set_interrupt_requested(false);
  comparison.options.progress = {};
  comparison.options.resume = true;
  const ComparisonResult whole = comparison.run();
  CHECK(!whole.interrupted);
  CHECK(whole.pieces.size() == 16);
  for (const PieceResult& piece : whole.pieces) CHECK(piece.failure == "");
}

TEST_CASE("what fails while a result is kept stops all devices and is reported") {
  if (!test::lends_two_devices()) return test::skip("PoCL, which lends two devices");
  const TwoDevices two;
  SharedComparison comparison;
  comparison.options.executor.devices = {"0", "1"};
  comparison.options.progress = [&](const std::string& line) {
    if (line.starts_with("[2/")) throw Error(ErrorClass::input, "the disk is full");
  };
  CHECK_THROWS_WITH_AS(comparison.run(), "the disk is full", Error);
}
