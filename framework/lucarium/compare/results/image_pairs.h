// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace lucarium {

struct ComparisonResult;
using SummaryKey = std::tuple<size_t, size_t, size_t>;

/// Errors of one variant's images against another's, and of layers against the reference's. With equal seeds both draw
/// the same random numbers, so that noise, which both have, does not hide what differs.
class ImagePairs {
 public:
  /// `folder`: of the comparison's results.
  explicit ImagePairs(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Means over the seeds that both have of all metrics, by name, and of `differing_pixels`, the share of the pixels
  /// with |x − r| > .01 (|r| + .01 Ȳ) in some channel (the terms of MAPE); empty where there is no such pair. Each pair
  /// of images is measured once.
  std::map<std::string, double> measure(const ComparisonResult& result, const SummaryKey& test,
                                        const SummaryKey& reference);

  /// Means over the seeds of all metrics of one layer alone against that of the reference; empty where an image has no
  /// such layer of colours.
  std::map<std::string, double> measure_layer(const ComparisonResult& result, const SummaryKey& test,
                                              const std::string& layer);

 private:
  using Errors = std::map<std::string, double>;
  const Errors& measure_pair(const std::string& test, const std::string& reference, float exposure);
  const Errors& measure_layer_pair(const std::string& test, const std::string& reference, const std::string& layer,
                                   float exposure);
  std::filesystem::path folder_;
  std::map<std::pair<std::string, std::string>, Errors> known_;
};

/// Share of the pixels that differ, as above. `test` and `reference`: RGB of images of equal size.
double differing_pixels(const std::vector<float>& test, const std::vector<float>& reference);

}  // namespace lucarium
