// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace lucarium {

/// An image file that the report shows, with what its header says. Indices are those of results.json.
struct ReportSource {
  enum class Kind { reference, piece, mean };
  Kind kind = Kind::piece;
  std::filesystem::path file;
  size_t scene = 0, reference = 0;  ///< the reference that it is, or is compared with
  size_t variant = 0, budget = 0;   ///< of pieces and means
  uint32_t seed = 0;                ///< of pieces
  uint32_t width = 0, height = 0;   ///< 0 when the file cannot be read
  uint32_t layer_channels = 0;      ///< besides the image
  double exposure_stops = 0;        ///< of the scene
};

/// How much of the images a page of limited size can carry.
struct ReportPlan {
  uint32_t image_divisor = 1, mean_divisor = 1;  ///< of the resolution
  uint32_t layer_divisor = 2;                    ///< of layers and FLIP maps
  double byte_limit = 0;                         ///< for all images; 0: none

  /// Notes for readers about reduced images, in plain words; empty when there are none.
  std::vector<std::string> notes() const;
};

/// References, first finished seed of every variant and budget, means over seeds: those whose files are there.
std::vector<ReportSource> list_report_sources(const nlohmann::ordered_json& results,
                                              const std::filesystem::path& folder);

/// The least reduction that leaves every value half a byte, 0 for no limit.
ReportPlan plan_report_images(const std::vector<ReportSource>& sources, double byte_limit);

/// Receives one image: what it is (a line of the page's list of images: `kind` reference, image, mean, layer or flip,
/// indices, size, precision) and its bytes (PackedImage::data).
using ReportImageSink = std::function<void(nlohmann::ordered_json entry, const std::string& data)>;

/// Packs all images in the order of `sources`.
void pack_report_images(const std::vector<ReportSource>& sources, const ReportPlan& plan, const ReportImageSink& sink);

}  // namespace lucarium
