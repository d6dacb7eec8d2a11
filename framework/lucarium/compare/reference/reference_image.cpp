// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/reference/reference_image.h"

#include <charconv>

#include "lucarium/base/error.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium {
namespace {

/// Chance that right halves are reported to differ. Every reference is tested: an alarm must be rarer than in a test
/// that one asks for.
constexpr double halves_level = 1e-4;
constexpr std::array<const char*, ReferenceImage::halves> half_layers = {"HalfA", "HalfB"};
constexpr std::array<const char*, ReferenceImage::halves> half_keys = {"half_a_samples", "half_b_samples"};
const char* const variance_layer = "Variance";

/// mean ← (n·mean + m·value) / (n + m), in double precision.
void merge(std::vector<float>& mean, double n, const std::vector<float>& value, double m) {
  for (size_t i = 0; i < mean.size(); ++i) mean[i] = static_cast<float>((n * mean[i] + m * value[i]) / (n + m));
}

/// Variance of the mean of two independent means: (n²·V + m²·W) / (n + m)².
void merge_variance(std::vector<float>& variance, double n, const std::vector<float>& other, double m) {
  const double total = (n + m) * (n + m);
  for (size_t i = 0; i < variance.size(); ++i) {
    variance[i] = static_cast<float>((n * n * variance[i] + m * m * other[i]) / total);
  }
}

const char* const squares_key = "round_samples_squared";
const char* const round_dof_key = "round_variance_dof";

double read_number(const Film& film, const char* key) {
  const auto entry = film.metadata.find(key);
  double value = 0;
  if (entry == film.metadata.end()) return 0;
  std::from_chars(entry->second.data(), entry->second.data() + entry->second.size(), value);
  return value;
}

uint64_t read_count(const Film& film, const char* key, const std::string& shown_name) {
  const auto entry = film.metadata.find(key);
  uint64_t value = 0;
  if (entry != film.metadata.end()) {
    const std::string& text = entry->second;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure == std::errc() && end == text.data() + text.size()) return value;
  }
  throw_error(ErrorClass::input, "{}: not an image of lucarium reference ('{}' is missing in its header)", shown_name,
              key);
}

/// Averages of the squared errors of an image's values.
ReferenceError average_errors(const std::vector<float>& image, const std::vector<double>& squared_errors) {
  const double luminance = mean_luminance(image);
  const double floor = 0.01 * luminance * luminance;
  ReferenceError error;
  for (size_t i = 0; i < image.size(); ++i) {
    error.mse += squared_errors[i];
    const double scale = double{image[i]} * image[i] + floor;
    if (scale > 0) error.relmse += squared_errors[i] / scale;
  }
  error.mse /= static_cast<double>(image.size());
  error.relmse /= static_cast<double>(image.size());
  return error;
}

ReferenceError error_of_halves(const Film& film, double a, double b) {
  const std::vector<float>& first = film.find(half_layers[0])->pixels;
  const std::vector<float>& second = film.find(half_layers[1])->pixels;
  const double weight = a * b / ((a + b) * (a + b));
  std::vector<double> squared_errors(first.size());
  for (size_t i = 0; i < first.size(); ++i) {
    const double difference = double{first[i]} - second[i];
    squared_errors[i] = difference * difference * weight;
  }
  return average_errors(film.image(), squared_errors);
}

}  // namespace

ReferenceImage::ReferenceImage(uint32_t width, uint32_t height) : film_(width, height) {}

ReferenceImage::ReferenceImage(Film film, const std::string& shown_name) : film_(std::move(film)) {
  rounds_ = read_count(film_, "rounds", shown_name);
  squares_ = read_number(film_, squares_key);
  round_dof_ = read_number(film_, round_dof_key);
  for (size_t half = 0; half < halves; ++half) {
    samples_[half] = read_count(film_, half_keys[half], shown_name);
    if (samples_[half] > 0 && !film_.find(half_layers[half])) {
      throw_error(ErrorClass::input, "{}: its layer {} is missing", shown_name, half_layers[half]);
    }
  }
}

void ReferenceImage::add(const Film& round, uint64_t samples, size_t half) {
  if (round.width() != film_.width() || round.height() != film_.height()) {
    throw_error(ErrorClass::internal, "cannot add a round of another image size to a reference");
  }
  if (samples == 0) return;
  const double before = static_cast<double>(this->samples()), more = static_cast<double>(samples);
  for (const FilmLayer& layer : round.layers()) {
    const bool known = film_.find(layer.name);
    FilmLayer& sum = film_.layer(layer.name, layer.channels, layer.additive);
    if (!known) {
      if (before > 0) throw_error(ErrorClass::internal, "layer {} appears in a later round of a reference", layer.name);
      sum.pixels = layer.pixels;
    } else if (layer.additive) {
      merge(sum.pixels, before, layer.pixels, more);
    } else if (layer.name == variance_layer) {
      merge_variance(sum.pixels, before, layer.pixels, more);
    }
  }
  FilmLayer& sum = film_.layer(half_layers[half]);
  merge(sum.pixels, static_cast<double>(samples_[half]), round.image(), more);
  samples_[half] += samples;
  squares_ += more * more;
  round_dof_ = read_number(round, "variance_dof");
  ++rounds_;
}

ReferenceError ReferenceImage::error() const {
  if (!error_known()) return {};
  return error_of_halves(film_, static_cast<double>(samples_[0]), static_cast<double>(samples_[1]));
}

double ReferenceImage::variance_dof() const {
  // Welch and Satterthwaite, with the same variance per sample in all rounds.
  const double total = static_cast<double>(samples());
  return squares_ > 0 ? round_dof_ * total * total / squares_ : 0;
}

ImageTest ReferenceImage::test_halves() const {
  const FilmLayer* variance = film_.find(variance_layer);
  ImageTest passed;
  passed.passed = true;
  if (!variance || !error_known() || variance_dof() <= 0) return passed;
  std::array<ImageEstimate, halves> estimates;
  for (size_t half = 0; half < halves; ++half) {
    const std::vector<float>& image = film_.find(half_layers[half])->pixels;
    const double scale = static_cast<double>(samples()) / static_cast<double>(samples_[half]);
    ImageEstimate& estimate = estimates[half];
    estimate.width = film_.width();
    estimate.height = film_.height();
    estimate.mean.assign(image.begin(), image.end());
    estimate.variance.assign(variance->pixels.begin(), variance->pixels.end());
    for (double& value : estimate.variance) value *= scale;
    // Both variances come from all rounds: Welch adds the degrees of freedom of the two.
    estimate.dof = variance_dof() / 2;
  }
  return test_images(estimates[0], estimates[1], {.level = halves_level, .image_level = halves_level / 10});
}

const Film& ReferenceImage::film() {
  film_.metadata["samples"] = std::to_string(samples());
  film_.metadata["rounds"] = std::to_string(rounds_);
  film_.metadata[squares_key] = fmt::format("{}", squares_);
  film_.metadata[round_dof_key] = fmt::format("{}", round_dof_);
  film_.metadata["variance_dof"] = fmt::format("{}", variance_dof());
  for (size_t half = 0; half < halves; ++half) film_.metadata[half_keys[half]] = std::to_string(samples_[half]);
  if (error_known()) {
    const ReferenceError own = error();
    film_.metadata["own_mse"] = fmt::format("{}", own.mse);
    film_.metadata["own_relmse"] = fmt::format("{}", own.relmse);
  }
  return film_;
}

bool estimate_reference_error(const Film& film, ReferenceError& error) {
  if (film.metadata.count(half_keys[0])) {
    const ReferenceImage reference(film, "reference");
    error = reference.error();
    return reference.error_known();
  }
  const FilmLayer* variance = film.find(variance_layer);
  if (!variance) return false;
  error = average_errors(film.image(), {variance->pixels.begin(), variance->pixels.end()});
  return true;
}

}  // namespace lucarium
