// SPDX-License-Identifier: Apache-2.0
// results.json and results.csv.
#include <nlohmann/json.hpp>

#include "lucarium/base/error.h"
#include "lucarium/compare/comparison.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

ordered_json reference_json(const ReferenceResult& reference) {
  ordered_json json = {{"image", reference.image},
                       {"source", reference.source},
                       {"path_set", reference.path_set},
                       {"from_cache", reference.from_cache},
                       {"seconds", reference.seconds}};
  if (reference.error_known) {
    json["own_mse"] = reference.mse;
    json["own_relmse"] = reference.relmse;
  }
  return json;
}

ReferenceResult parse_reference(const ordered_json& json) {
  ReferenceResult reference;
  reference.image = json.at("image");
  reference.source = json.at("source");
  reference.path_set = json.at("path_set");
  reference.from_cache = json.at("from_cache");
  reference.seconds = json.at("seconds");
  reference.error_known = json.contains("own_relmse");
  reference.mse = json.value("own_mse", 0.0);
  reference.relmse = json.value("own_relmse", 0.0);
  return reference;
}

ordered_json piece_json(const PieceResult& piece) {
  ordered_json json = {{"scene", piece.scene}, {"variant", piece.variant}, {"seed", piece.seed}};
  if (!piece.failure.empty()) {
    json["failure"] = piece.failure;
    return json;
  }
  json["image"] = piece.image;
  json["seconds"] = piece.seconds;
  json["prepare_seconds"] = piece.prepare_seconds;
  json["compile_seconds"] = piece.compile_seconds;
  json["samples"] = piece.samples;
  json["rmse"] = piece.rmse;
  json["relmse"] = piece.relmse;
  json["peak_memory_bytes"] = piece.peak_memory_bytes;
  json["render"] = piece.render_summary.empty() ? ordered_json() : ordered_json::parse(piece.render_summary);
  return json;
}

PieceResult parse_piece(const ordered_json& json) {
  PieceResult piece;
  piece.scene = json.at("scene");
  piece.variant = json.at("variant");
  piece.seed = json.at("seed");
  piece.failure = json.value("failure", std::string());
  if (!piece.failure.empty()) return piece;
  piece.image = json.at("image");
  piece.seconds = json.at("seconds");
  piece.prepare_seconds = json.at("prepare_seconds");
  piece.compile_seconds = json.at("compile_seconds");
  piece.samples = json.at("samples");
  piece.rmse = json.at("rmse");
  piece.relmse = json.at("relmse");
  piece.peak_memory_bytes = json.at("peak_memory_bytes");
  if (!json.at("render").is_null()) piece.render_summary = json.at("render").dump();
  return piece;
}

SceneResult parse_scene(const ordered_json& json) {
  SceneResult scene;
  scene.name = json.at("name");
  scene.triangles = json.at("triangles");
  scene.hash = json.at("hash");
  scene.exposure = json.at("exposure_stops");
  scene.warnings = json.at("warnings").get<std::vector<std::string>>();
  scene.limitations = json.at("limitations").get<std::vector<std::vector<std::string>>>();
  scene.failure = json.value("failure", std::string());
  if (scene.failure.empty()) scene.reference = parse_reference(json.at("reference"));
  return scene;
}

std::string csv_field(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string ComparisonResult::to_json() const {
  ordered_json json;
  json["schema"] = "lucarium-results-1";
  json["version"] = version;
  json["device"] = device;
  json["driver"] = driver;
  json["interrupted"] = interrupted;
  json["comparison"] = ordered_json::parse(spec.to_json());
  json["metrics"] = {{"rmse", "sqrt(mean((x-r)^2)), mean over pixels and channels"},
                     {"relmse", "mean((x-r)^2 / (r^2 + 0.01 Y^2)), Y the reference's mean luminance"}};
  json["scenes"] = ordered_json::array();
  for (const SceneResult& scene : scenes) {
    ordered_json entry = {{"name", scene.name},         {"triangles", scene.triangles},
                          {"hash", scene.hash},         {"exposure_stops", scene.exposure},
                          {"warnings", scene.warnings}, {"limitations", scene.limitations}};
    if (scene.failure.empty()) {
      entry["reference"] = reference_json(scene.reference);
    } else {
      entry["failure"] = scene.failure;
    }
    json["scenes"].push_back(std::move(entry));
  }
  json["pieces"] = ordered_json::array();
  for (const PieceResult& piece : pieces) json["pieces"].push_back(piece_json(piece));
  return json.dump(2) + "\n";
}

ComparisonResult ComparisonResult::parse(const std::string& text, const std::string& shown_name) {
  try {
    const ordered_json json = ordered_json::parse(text);
    if (json.at("schema") != "lucarium-results-1") {
      throw_error(ErrorClass::input, "{}: schema {} is not known to this version", shown_name, json.at("schema").dump());
    }
    ComparisonResult result;
    result.spec = ComparisonSpec::parse(json.at("comparison").dump(), shown_name);
    result.version = json.at("version");
    result.device = json.at("device");
    result.driver = json.at("driver");
    result.interrupted = json.at("interrupted");
    for (const ordered_json& scene : json.at("scenes")) result.scenes.push_back(parse_scene(scene));
    for (const ordered_json& piece : json.at("pieces")) {
      result.pieces.push_back(parse_piece(piece));
      if (result.pieces.back().scene >= result.scenes.size() ||
          result.pieces.back().variant >= result.spec.variants.size()) {
        throw_error(ErrorClass::input, "{}: a piece names a scene or variant that is not there", shown_name);
      }
    }
    return result;
  } catch (const nlohmann::json::exception& error) {
    throw_error(ErrorClass::input, "{}: not a results file: {}", shown_name, error.what());
  }
}

std::string ComparisonResult::to_csv() const {
  std::string csv =
      "scene,variant,seed,samples,seconds,prepare_seconds,compile_seconds,rmse,relmse,reference_relmse,failure\n";
  for (const PieceResult& piece : pieces) {
    const SceneResult& scene = scenes.at(piece.scene);
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", csv_field(scene.name),
                       csv_field(spec.variants.at(piece.variant).label()), piece.seed, piece.samples, piece.seconds,
                       piece.prepare_seconds, piece.compile_seconds, piece.rmse, piece.relmse, scene.reference.relmse,
                       csv_field(piece.failure));
  }
  return csv;
}

}  // namespace lucarium
