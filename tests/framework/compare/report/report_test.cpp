// SPDX-License-Identifier: Apache-2.0
// What the report is made of: packed images, their plan, and a page that no text breaks out of.
#include <doctest/doctest.h>

#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/compare/report/packed_image.h"
#include "lucarium/compare/report/report_images.h"
#include "lucarium/compare/report/report_page.h"
#include "report_example.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

std::vector<float> noisy_values(size_t count, float spread) {
  std::mt19937 generator(7);
  std::lognormal_distribution<float> values(0.0f, spread);
  std::vector<float> list(count);
  for (float& value : list) value = values(generator);
  return list;
}

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

}  // namespace

TEST_CASE("packed values are within half a step, of either sign, over many stops") {
  std::vector<float> values = noisy_values(61 * 37 * 3, 3.0f);
  for (size_t i = 0; i < values.size(); i += 5) values[i] = -values[i];
  values[17] = 0;
  for (const float unit : {1e-6f, 1.0f, 1e6f}) {
    std::vector<float> scaled = values;
    for (float& value : scaled) value *= unit;
    const PackedImage packed = pack_hdr(61, 37, 3, scaled);
    CHECK(packed.mantissa_bits == packed_mantissa_bits);
    const std::vector<float> shown = unpack(packed);
    const float floor = std::ldexp(1.0f, packed.exponent - 14);  // smallest normal value
    for (size_t i = 0; i < scaled.size(); ++i) {
      const float step = std::max(std::abs(scaled[i]), floor) * std::ldexp(1.0f, -packed_mantissa_bits - 1);
      if (std::abs(shown[i] - scaled[i]) > 1.001f * step) FAIL_CHECK(i << ": " << scaled[i] << " became " << shown[i]);
    }
  }
}

TEST_CASE("values that are not finite stay so; a firefly does not darken the rest") {
  std::vector<float> values(8 * 8, 1.0f);
  values[3] = std::numeric_limits<float>::quiet_NaN();
  values[4] = std::numeric_limits<float>::infinity();
  values[5] = 1e30f;
  for (const size_t limit : {SIZE_MAX, size_t{1}}) {  // 8 mantissa bits, and 1
    const std::vector<float> shown = unpack(pack_hdr(8, 8, 1, values, limit));
    CHECK(std::isnan(shown[3]));
    CHECK(std::isinf(shown[4]));
    CHECK(shown[5] > 1e6f);
    CHECK(shown[6] == 1.0f);
  }
}

TEST_CASE("precision gives way to a limit, and only as far as it must") {
  const std::vector<float> values = noisy_values(128 * 128 * 3, 0.3f);
  const PackedImage best = pack_hdr(128, 128, 3, values);
  const PackedImage less = pack_hdr(128, 128, 3, values, best.data.size() * 2 / 3);
  CHECK(less.data.size() <= best.data.size() * 2 / 3);
  CHECK(less.mantissa_bits < best.mantissa_bits);
  CHECK(pack_hdr(128, 128, 3, values, 1).mantissa_bits == 1);
}

TEST_CASE("damaged data is an error") {
  PackedImage packed = pack_hdr(8, 8, 1, std::vector<float>(64, 1.0f));
  packed.data.resize(packed.data.size() / 2);
  CHECK_THROWS_AS(unpack(packed), Error);
}

TEST_CASE("maps keep 8 bits; reduction is a mean, cut at the edges") {
  CHECK(unpack(pack_unit(2, 1, 1, {0.5f, 1.0f}))[0] == test::relative(0.5, 0.005));
  const std::vector<float> reduced = reduce_image(3, 2, 1, {1, 3, 7, 5, 7, 9}, 2);
  REQUIRE(reduced.size() == 2);
  CHECK(reduced[0] == test::relative(4));
  CHECK(reduced[1] == test::relative(8));
}

TEST_CASE("layers give way before means, means before images") {
  std::vector<ReportSource> sources(10);
  for (ReportSource& source : sources) {
    source.width = source.height = 1000;
    source.layer_channels = 6;
  }
  CHECK(plan_report_images(sources, 1e9).layer_divisor == 2);
  CHECK(plan_report_images(sources, 1e9).image_divisor == 1);
  const ReportPlan tight = plan_report_images(sources, 18e6);
  CHECK(tight.layer_divisor > 2);
  CHECK(tight.image_divisor == 1);
  CHECK(plan_report_images(sources, 2e6).image_divisor > 1);
  CHECK(plan_report_images(sources, 0).layer_divisor == 1);
  CHECK(plan_report_images(sources, 0).notes().empty());
}

TEST_CASE("a page holds all pictures, and no text of the results ends a script") {
  const test::TemporaryFolder folder;
  test::write_report_example(folder.path());
  write_report(folder.path());
  const std::string page = read_file(folder.path() / "report.html");
  CHECK(page.find("@include") == std::string::npos);
  CHECK(page.find("<img") == std::string::npos);
  CHECK(page.find("src=\"http") == std::string::npos);
  CHECK(count_of(page, "<script") == count_of(page, "</script"));
  // 2 references and 5 pieces with 3 layers each, 5 FLIP maps, 5 means.
  CHECK(count_of(page, "<script type=\"text/plain\" id=\"image-") == 7 * 4 + 5 + 5);
}

TEST_CASE("linked images lie beside the page, and go when it carries them again") {
  const test::TemporaryFolder folder;
  test::write_report_example(folder.path());
  write_report(folder.path(), {.link_images = true});
  CHECK(std::filesystem::exists(folder.path() / "report_images/0.js"));
  CHECK(read_file(folder.path() / "report.html").find("id=\"image-0\"") == std::string::npos);
  write_report(folder.path());
  CHECK(!std::filesystem::exists(folder.path() / "report_images"));
}

TEST_CASE("a damaged or missing image is left out, and the page is made all the same") {
  const test::TemporaryFolder folder;
  test::write_report_example(folder.path());
  const std::filesystem::path damaged = folder.path() / "pieces/scene1-variant1-budget1-seed1.exr";
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  std::filesystem::remove(folder.path() / "references/scene2-set1.exr");
  write_report(folder.path());
  // As above without a piece of one scene, the reference of the other, and its three FLIP maps.
  CHECK(count_of(read_file(folder.path() / "report.html"), "<script type=\"text/plain\" id=\"image-") == 5 * 4 + 1 + 5);
}

TEST_CASE("results of another schema, or none, are an error that names the file") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH_AS(write_report(folder.path()), doctest::Contains("results.json"), Error);
  for (const char* text : {"{}", "[1]", "{\"schema\": \"lucarium-results-1\"}", "{"}) {
    write_file_atomically(folder.path() / "results.json", text);
    CHECK_THROWS_WITH_AS(write_report(folder.path()), doctest::Contains("results.json"), Error);
  }
}
