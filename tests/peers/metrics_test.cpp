// SPDX-License-Identifier: Apache-2.0
// Our metrics against the Python packages flip-evaluator (the authors' FLIP) and scikit-image, where they are installed
// for the interpreter LUCARIUM_PEERS_PYTHON (default: python3).
#include "lucarium/metrics/metrics.h"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "lucarium/base/json.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using Image = std::vector<float>;

namespace {

constexpr uint32_t width = 160, height = 90;

void write_raw(const std::filesystem::path& file, const Image& image) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size() * sizeof(float)));
}

Image read_raw(const std::filesystem::path& file) {
  Image map(size_t{width} * height);
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(map.data()), static_cast<std::streamsize>(map.size() * sizeof(float)));
  return map;
}

/// Coloured waves over `stops` stops of radiance, and the same with multiplicative noise.
std::pair<Image, Image> noisy_waves(float stops) {
  Image reference, test;
  uint32_t state = 1;
  const auto random = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / 16777216.f; };
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const auto u = static_cast<float>(x) / width, v = static_cast<float>(y) / height;
      const float level = 0.4f * std::exp2(stops * (u - 0.5f));
      for (uint32_t c = 0; c < 3; ++c) {
        const float value =
            level * (1 + 0.8f * std::sin(static_cast<float>(7 + 5 * c) * v + static_cast<float>(20 + 9 * c) * u * v));
        reference.push_back(value);
        test.push_back(value * (0.7f + 0.6f * random()));
      }
    }
  }
  return {reference, test};
}

nlohmann::json peer_values(const Image& reference, const Image& test, const std::filesystem::path& folder) {
  write_raw(folder / "reference", reference);
  write_raw(folder / "test", test);
  const char* python = std::getenv("LUCARIUM_PEERS_PYTHON");
  const char* source = std::getenv("LUCARIUM_TEST_SOURCE");
  const std::string in = folder.string();
  const test::ProgramResult result =
      test::run_program(fmt::format("'{}' '{}/tests/peers/metrics.py' {} {} '{}/reference' '{}/test' '{}'",
                                    python ? python : "python3", source ? source : ".", width, height, in, in, in));
  return result.exit_code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json::object();
}

double greatest_difference(const Image& a, const Image& b) {
  double greatest = 0;
  for (size_t i = 0; i < a.size(); ++i) greatest = std::max(greatest, std::abs(double{a[i]} - b[i]));
  return greatest;
}

}  // namespace

TEST_CASE("FLIP is that of flip-evaluator, pixel by pixel") {
  const test::TemporaryFolder folder;
  for (const float stops : {2.f, 10.f}) {
    const auto [reference, image] = noisy_waves(stops);
    const nlohmann::json peer = peer_values(reference, image, folder.path());
    if (!peer.contains("HDR_FLIP")) return test::skip("Python package flip-evaluator");
    const HdrFlipExposures exposures = hdr_flip_exposures(reference);
    CHECK(exposures.start == test::relative(peer["start"].get<double>(), 1e-5));
    CHECK(exposures.stop == test::relative(peer["stop"].get<double>(), 1e-5));
    CHECK(exposures.count == peer["count"].get<uint32_t>());

    const ImageMetrics ours = compute_metrics(width, height, image, reference);
    const Image ldr = FlipReference(width, height, reference, {{0, false}}).error_map(image),
                hdr = FlipReference(width, height, reference, hdr_flip_views(exposures)).error_map(image);
    const double ldr_pixel = greatest_difference(ldr, read_raw(folder.path() / "ldr")),
                 hdr_pixel = greatest_difference(hdr, read_raw(folder.path() / "hdr"));
    std::printf(
        "%g stops: LDR-FLIP %.6f (peer %.6f, pixels within %.1e), HDR-FLIP %.6f (peer %.6f, pixels within %.1e)\n",
        double{stops}, ours.ldr_flip, peer["LDR_FLIP"].get<double>(), ldr_pixel, ours.hdr_flip,
        peer["HDR_FLIP"].get<double>(), hdr_pixel);
    CHECK(std::abs(ours.ldr_flip - peer["LDR_FLIP"].get<double>()) < 1e-5);
    CHECK(std::abs(ours.hdr_flip - peer["HDR_FLIP"].get<double>()) < 1e-5);
    CHECK(ldr_pixel < 1e-3);
    CHECK(hdr_pixel < 1e-3);
  }
}

TEST_CASE("SSIM and PSNR are those of scikit-image") {
  const test::TemporaryFolder folder;
  const auto [reference, image] = noisy_waves(4);
  const nlohmann::json peer = peer_values(reference, image, folder.path());
  if (!peer.contains("SSIM")) return test::skip("Python package scikit-image");
  const ImageMetrics ours = compute_metrics(width, height, image, reference);
  std::printf("SSIM %.9f (peer %.9f), PSNR %.9f (peer %.9f)\n", ours.ssim, peer["SSIM"].get<double>(), ours.psnr,
              peer["PSNR"].get<double>());
  CHECK(ours.ssim == test::relative(peer["SSIM"].get<double>(), 1e-7));
  CHECK(ours.psnr == test::relative(peer["PSNR"].get<double>(), 1e-7));
}
