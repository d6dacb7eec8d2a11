// SPDX-License-Identifier: Apache-2.0
// One self-contained HTML page: pictures, error maps, table and plot per scene. The page, its style and its script are
// framework/compare/report/*, embedded at build time; this file fills in the data.
#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lucarium/base/atomic_file.h"
#include "lucarium/compare/comparison.h"
#include "lucarium/compare/error_map.h"
#include "lucarium/compute/embedded_sources.h"
#include "lucarium/film/image_io.h"

const lucarium::EmbeddedSources& lucarium_report_assets();

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

std::string png_data_uri(uint32_t width, uint32_t height, const std::vector<float>& rgb, float exposure) {
  return "data:image/png;base64," + OIIO::Strutil::base64_encode(encode_png(width, height, rgb, exposure));
}

/// Replaces the one occurrence of `marker`.
void substitute(std::string& page, const std::string& marker, const std::string& text) {
  page.replace(page.find(marker), marker.size(), text);
}

/// JSON inside a <script> element must not contain "</".
std::string script_safe(std::string json) {
  for (size_t at = 0; (at = json.find("</", at)) != std::string::npos; at += 3) json.replace(at, 2, "<\\/");
  return json;
}

/// "all", or what is left out, in words.
std::string describe_path_set(const std::string& text) {
  std::string differences;
  for (const std::string& line : PathSet::parse(text).differences(PathSet())) {
    const std::string field = line.substr(0, line.find(" against "));
    differences += (differences.empty() ? "" : ", ") + field;
  }
  return differences.empty() ? "all" : "all but " + differences;
}

/// Table row of one variant: mean over its seeds; relMSE as a geometric mean, since errors spread by factors.
ordered_json variant_row(const ComparisonResult& result, size_t scene, size_t variant) {
  ordered_json row = {{"label", result.spec.variants[variant].label()}};
  double log_sum = 0, low = INFINITY, high = 0, rmse = 0, seconds = 0, prepare = 0, compile = 0;
  uint64_t samples = 0;
  size_t memory = 0, count = 0;
  std::string failure;
  for (const PieceResult& piece : result.pieces) {
    if (piece.scene != scene || piece.variant != variant) continue;
    if (!piece.failure.empty()) {
      failure = piece.failure;
      continue;
    }
    ++count;
    log_sum += std::log(std::max(piece.relmse, 1e-300));
    low = std::min(low, piece.relmse);
    high = std::max(high, piece.relmse);
    rmse += piece.rmse;
    seconds += piece.seconds;
    prepare += piece.prepare_seconds;
    compile += piece.compile_seconds;
    samples += piece.samples;
    memory = std::max(memory, piece.peak_memory_bytes);
  }
  if (count == 0) {
    row["failure"] = failure.empty() ? "not run" : failure;
    return row;
  }
  const double n = static_cast<double>(count);
  const double relmse = std::exp(log_sum / n);
  row.update({{"seeds", count}, {"samples", samples / count}, {"seconds", seconds / n}, {"prepare_seconds", prepare / n},
              {"compile_seconds", compile / n}, {"relmse", relmse}, {"relmse_low", low}, {"relmse_high", high},
              {"rmse", rmse / n}, {"peak_memory_bytes", memory}});
  std::vector<std::string> notes = result.scenes[scene].limitations[variant];
  if (!failure.empty()) notes.push_back("some seeds failed: " + failure);
  if (result.scenes[scene].reference.error_known && result.scenes[scene].reference.relmse > relmse / 10) {
    notes.push_back("close to what this reference can resolve: raise --reference-spp");
  }
  std::string note;
  for (const std::string& line : notes) note += (note.empty() ? "" : "; ") + line;
  row["note"] = note;
  return row;
}

/// Reference, then picture and error map of each variant's first finished seed.
ordered_json pictures(const ComparisonResult& result, size_t scene, const fs::path& folder) {
  ordered_json list = ordered_json::array();
  const SceneResult& entry = result.scenes[scene];
  if (!entry.failure.empty() || !fs::exists(folder / entry.reference.image)) return list;
  const Film reference = read_image(folder / entry.reference.image);
  const std::vector<float> truth = reference.image();
  const uint32_t width = reference.width(), height = reference.height();
  list.push_back({{"name", "reference"}, {"data", png_data_uri(width, height, truth, entry.exposure)}});
  for (size_t variant = 0; variant < result.spec.variants.size(); ++variant) {
    for (const PieceResult& piece : result.pieces) {
      if (piece.scene != scene || piece.variant != variant || piece.image.empty()) continue;
      const std::vector<float> image = read_image(folder / piece.image).image();
      const std::string label = result.spec.variants[variant].label();
      list.push_back({{"name", label}, {"data", png_data_uri(width, height, image, entry.exposure)}});
      list.push_back({{"name", "error of " + label}, {"data", png_data_uri(width, height, signed_error_map(image, truth), 0)}});
      break;
    }
  }
  return list;
}

ordered_json scene_data(const ComparisonResult& result, size_t index, const fs::path& folder) {
  const SceneResult& scene = result.scenes[index];
  ordered_json data = {{"name", scene.name}, {"warnings", scene.warnings}, {"rows", ordered_json::array()}};
  data["reference_relmse"] = scene.reference.relmse;
  data["pictures"] = pictures(result, index, folder);
  if (!scene.failure.empty()) {
    data["text"] = scene.failure;
    return data;
  }
  data["text"] = fmt::format("{} triangles. Reference: {}{}. Light paths: {}.", scene.triangles, scene.reference.source,
                             scene.reference.error_known
                                 ? fmt::format(", its own relMSE {:.2g}", scene.reference.relmse)
                                 : std::string(", its own error unknown"),
                             describe_path_set(scene.reference.path_set));
  double best = INFINITY;
  for (size_t variant = 0; variant < result.spec.variants.size(); ++variant) {
    data["rows"].push_back(variant_row(result, index, variant));
    best = std::min(best, data["rows"].back().value("relmse", double{INFINITY}));
  }
  for (ordered_json& row : data["rows"]) row["best"] = row.value("relmse", double{INFINITY}) == best;
  return data;
}

}  // namespace

void write_report(const ComparisonResult& result, const fs::path& folder) {
  const ComparisonSpec& spec = result.spec;
  ordered_json data;
  data["summary"] = fmt::format(
      "{} at {}×{}, {} seeds each, {}. Lucarium {} on {} (driver {}).{}",
      spec.budget.seconds > 0 ? fmt::format("Equal time: {:g} s of iterating", spec.budget.seconds)
                              : fmt::format("Equal iterations: {}", spec.budget.iterations),
      spec.width, spec.height, spec.seeds,
      spec.max_bounces < 0 ? std::string("unlimited bounces") : fmt::format("at most {} bounces", spec.max_bounces),
      result.version, result.device, result.driver,
      result.interrupted ? " Interrupted: what is here was finished before; continue with --resume." : "");
  data["scenes"] = ordered_json::array();
  for (size_t i = 0; i < result.scenes.size(); ++i) data["scenes"].push_back(scene_data(result, i, folder));
  data["provenance"] = result.to_json();

  const EmbeddedSources& assets = lucarium_report_assets();
  std::string page(assets.at("report.html"));
  substitute(page, "@STYLE@", std::string(assets.at("report.css")));
  substitute(page, "@SCRIPT@", std::string(assets.at("report.js")));
  substitute(page, "@DATA@", script_safe(data.dump()));
  write_file_atomically(folder / "report.html", page);
}

}  // namespace lucarium
