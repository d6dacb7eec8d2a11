// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/report/report_images.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/compare/report/packed_image.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/flip.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// Appends the source with its size, unless the file is missing or not an image.
void add_source(std::vector<ReportSource>& sources, ReportSource source) {
  const auto input = fs::is_regular_file(source.file) ? OIIO::ImageInput::open(source.file.string()) : nullptr;
  if (!input) return;
  source.width = static_cast<uint32_t>(input->spec().width);
  source.height = static_cast<uint32_t>(input->spec().height);
  source.layer_channels = static_cast<uint32_t>(std::max(input->spec().nchannels - 3, 0));
  sources.push_back(std::move(source));
}

/// A damaged image is left out of the page; the rest is worth showing.
std::optional<Film> read_or_warn(const fs::path& file) {
  try {
    return read_image(file);
  } catch (const Error& error) {
    log_warning("report: left out: {}", error.what());
    return std::nullopt;
  }
}

/// Index of the reference that a variant is compared with.
size_t reference_of(const ordered_json& scene, size_t variant) {
  const auto variants = scene.find("variants");
  if (variants == scene.end() || variant >= variants->size()) return 0;
  return (*variants)[variant].value("reference", size_t{0});
}

double samples_of(const std::vector<ReportSource>& sources, const ReportPlan& plan) {
  double samples = 0;
  const auto reduced = [](double count, uint32_t divisor) { return count / (double{1} * divisor * divisor); };
  for (const ReportSource& source : sources) {
    const double pixels = double{1} * source.width * source.height;
    samples += reduced(3 * pixels, source.kind == ReportSource::Kind::mean ? plan.mean_divisor : plan.image_divisor);
    if (source.kind == ReportSource::Kind::mean) continue;
    const uint32_t flip_channels = source.kind == ReportSource::Kind::piece ? 1 : 0;
    samples += reduced((source.layer_channels + flip_channels) * pixels, plan.layer_divisor);
  }
  return samples;
}

std::string fraction(uint32_t divisor) {
  return divisor == 2 ? "half" : divisor == 4 ? "a quarter of" : fmt::format("1/{} of", divisor);
}

/// Layers of one or three channels are shown as they are, two get an empty third, of more the first three are shown.
std::vector<float> shown_channels(const FilmLayer& layer, size_t pixels, uint32_t& channels) {
  const size_t stored = layer.channels.size();
  channels = stored == 1 ? 1 : 3;
  if (stored == channels) return layer.pixels;
  std::vector<float> values(pixels * 3, 0.0f);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < std::min<size_t>(stored, 3); ++c) values[3 * i + c] = layer.pixels[i * stored + c];
  }
  return values;
}

/// Splits the remaining byte budget over the remaining images, so that small images leave more for the others.
class ImagePacker {
 public:
  ImagePacker(const ReportPlan& plan, double samples, const ReportImageSink& sink)
      : sink_(sink), limited_(plan.byte_limit > 0), bytes_left_(plan.byte_limit), samples_left_(samples) {}

  void pack(ordered_json entry, uint32_t width, uint32_t height, uint32_t channels, const std::vector<float>& values,
            uint32_t divisor) {
    const std::vector<float> reduced = reduce_image(width, height, channels, values, divisor);
    const double share = bytes_left_ * static_cast<double>(reduced.size()) /
                         std::max(samples_left_, static_cast<double>(reduced.size()));
    send(std::move(entry), divisor,
         pack_hdr((width + divisor - 1) / divisor, (height + divisor - 1) / divisor, channels, reduced,
                  limited_ ? static_cast<size_t>(std::max(share, 0.0)) : SIZE_MAX));
  }

  void pack_map(ordered_json entry, uint32_t width, uint32_t height, const std::vector<float>& values,
                uint32_t divisor) {
    send(std::move(entry), divisor,
         pack_unit((width + divisor - 1) / divisor, (height + divisor - 1) / divisor, 1,
                   reduce_image(width, height, 1, values, divisor)));
  }

 private:
  void send(ordered_json entry, uint32_t divisor, const PackedImage& image) {
    bytes_left_ -= static_cast<double>(image.data.size());
    samples_left_ -= static_cast<double>(image.width) * image.height * image.channels;
    entry.update({{"width", image.width},
                  {"height", image.height},
                  {"channels", image.channels},
                  {"divisor", divisor},
                  {"mantissa_bits", image.mantissa_bits},
                  {"exponent", image.exponent}});
    sink_(std::move(entry), image.data);
  }

  const ReportImageSink& sink_;
  bool limited_;
  double bytes_left_, samples_left_;
};

ordered_json describe(const ReportSource& source) {
  static const char* const kinds[] = {"reference", "image", "mean"};
  ordered_json entry = {
      {"kind", kinds[static_cast<int>(source.kind)]}, {"scene", source.scene}, {"reference", source.reference}};
  if (source.kind != ReportSource::Kind::reference)
    entry.update({{"variant", source.variant}, {"budget", source.budget}});
  if (source.kind == ReportSource::Kind::piece) entry["seed"] = source.seed;
  return entry;
}

/// The layers that say more than the image.
std::vector<const FilmLayer*> shown_layers(const Film& film) {
  std::vector<const FilmLayer*> layers;
  const auto& all = film.layers();
  const auto additive = std::count_if(all.begin(), all.end(), [](const FilmLayer& layer) { return layer.additive; });
  for (const FilmLayer& layer : all) {
    if (!layer.additive || additive > 1) layers.push_back(&layer);
  }
  return layers;
}

/// FLIP maps against the reference of the image before, which is prepared once for all techniques of a scene.
class FlipMaps {
 public:
  explicit FlipMaps(const std::vector<ReportSource>& sources) : sources_(sources) {}

  /// Empty when there is no reference of this size, or it has values that are not finite.
  std::vector<float> map(const ReportSource& source, const Film& film) {
    if (!prepared_ || scene_ != source.scene || index_ != source.reference) prepare(source);
    if (!reference_ || width_ != film.width() || height_ != film.height()) return {};
    return reference_->error_map(film.image());
  }

 private:
  void prepare(const ReportSource& source) {
    prepared_ = true;
    scene_ = source.scene;
    index_ = source.reference;
    reference_.reset();
    for (const ReportSource& other : sources_) {
      if (other.kind != ReportSource::Kind::reference || other.scene != scene_ || other.reference != index_) continue;
      const std::optional<Film> film = read_or_warn(other.file);
      if (!film) return;
      std::vector<float> image = film->image();
      if (!std::all_of(image.begin(), image.end(), [](float v) { return std::isfinite(v); })) return;
      width_ = film->width();
      height_ = film->height();
      reference_.emplace(width_, height_, std::move(image), std::vector<FlipView>{{source.exposure_stops, false}});
    }
  }

  const std::vector<ReportSource>& sources_;
  std::optional<FlipReference> reference_;
  bool prepared_ = false;
  size_t scene_ = 0, index_ = 0;
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace

std::vector<std::string> ReportPlan::notes() const {
  std::vector<std::string> notes;
  if (image_divisor > 1)
    notes.push_back(fmt::format("Images are kept at {} their resolution.", fraction(image_divisor)));
  if (mean_divisor > 1)
    notes.push_back(fmt::format("Means over seeds are kept at {} their resolution.", fraction(mean_divisor)));
  if (layer_divisor > 1)
    notes.push_back(fmt::format("Layers and FLIP maps are kept at {} their resolution.", fraction(layer_divisor)));
  return notes;
}

std::vector<ReportSource> list_report_sources(const ordered_json& results, const fs::path& folder) {
  std::vector<ReportSource> sources;
  const ordered_json none = ordered_json::array();
  const auto list = [&](const ordered_json& owner, const char* key) -> const ordered_json& {
    const auto found = owner.find(key);
    return found != owner.end() && found->is_array() ? *found : none;
  };
  const ordered_json& scenes = list(results, "scenes");
  for (size_t scene = 0; scene < scenes.size(); ++scene) {
    const ordered_json& references = list(scenes[scene], "references");
    for (size_t i = 0; i < references.size(); ++i) {
      if (!references[i].contains("image")) continue;
      add_source(sources,
                 {ReportSource::Kind::reference, folder / references[i]["image"].get<std::string>(), scene, i});
    }
  }
  std::set<std::tuple<size_t, size_t, size_t>> seen;
  for (const ordered_json& piece : list(results, "pieces")) {
    const auto scene = piece.value("scene", size_t{0}), variant = piece.value("variant", size_t{0});
    const auto budget = piece.value("budget", size_t{0});
    if (!piece.contains("image") || piece.contains("failure") || scene >= scenes.size()) continue;
    if (!seen.insert({scene, variant, budget}).second) continue;
    ReportSource source{ReportSource::Kind::piece,
                        folder / piece["image"].get<std::string>(),
                        scene,
                        reference_of(scenes[scene], variant),
                        variant,
                        budget,
                        piece.value("seed", 0u)};
    source.exposure_stops = scenes[scene].value("exposure_stops", 0.0);
    add_source(sources, source);
    source.kind = ReportSource::Kind::mean;
    source.file = folder / "means" / fmt::format("scene{}-variant{}-budget{}.exr", scene + 1, variant + 1, budget + 1);
    add_source(sources, source);
  }
  return sources;
}

ReportPlan plan_report_images(const std::vector<ReportSource>& sources, double byte_limit) {
  // Layers first, then means: what is compared most is reduced last.
  static const uint32_t divisors[][3] = {{1, 1, 2}, {1, 1, 4},  {1, 2, 4},  {1, 2, 8},  {1, 4, 8},
                                         {2, 4, 8}, {2, 8, 16}, {4, 8, 16}, {8, 16, 32}};
  if (byte_limit <= 0) return {1, 1, 1, 0};
  ReportPlan plan;
  for (const auto& [image, mean, layer] : divisors) {
    plan = {image, mean, layer, byte_limit};
    if (samples_of(sources, plan) * 0.5 <= byte_limit) break;
  }
  const auto is_mean = [](const ReportSource& source) { return source.kind == ReportSource::Kind::mean; };
  if (std::none_of(sources.begin(), sources.end(), is_mean)) plan.mean_divisor = 1;
  return plan;
}

void pack_report_images(const std::vector<ReportSource>& sources, const ReportPlan& plan, const ReportImageSink& sink) {
  ImagePacker packer(plan, samples_of(sources, plan), sink);
  FlipMaps flip(sources);
  for (const ReportSource& source : sources) {
    const std::optional<Film> read = read_or_warn(source.file);
    if (!read) continue;
    const Film& film = *read;
    const bool mean = source.kind == ReportSource::Kind::mean;
    packer.pack(describe(source), film.width(), film.height(), 3, film.image(),
                mean ? plan.mean_divisor : plan.image_divisor);
    if (mean) continue;
    if (source.kind == ReportSource::Kind::piece) {
      const std::vector<float> map = flip.map(source, film);
      ordered_json entry = describe(source);
      entry["kind"] = "flip";
      if (!map.empty()) packer.pack_map(std::move(entry), film.width(), film.height(), map, plan.layer_divisor);
    }
    for (const FilmLayer* layer : shown_layers(film)) {
      uint32_t channels = 0;
      const std::vector<float> values = shown_channels(*layer, film.pixel_count(), channels);
      ordered_json entry = describe(source);
      entry["of"] = entry["kind"];
      entry["kind"] = "layer";
      entry["layer"] = layer->name;
      packer.pack(std::move(entry), film.width(), film.height(), channels, values, plan.layer_divisor);
    }
  }
}

}  // namespace lucarium
