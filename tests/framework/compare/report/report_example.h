// SPDX-License-Identifier: Apache-2.0
// A made-up comparison with everything that a report can meet: results.json of schema 2 and its images.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"

namespace lucarium::test {

struct ReportExample {
  size_t scenes = 2, variants = 3, seeds = 2;
  uint32_t width = 96, height = 54;
  std::string hostile = "</script><img src=x onerror=alert(1)> <!-- & \" '";  ///< a name that tries to break out
};

/// A picture with edges, a bright lamp and smooth parts; `noise` is the relative standard deviation of a gamma
/// distribution, `bias` a relative offset of one corner.
inline Film example_film(const ReportExample& size, size_t scene, double noise, double bias, uint32_t seed) {
  Film film(size.width, size.height);
  std::mt19937 generator(seed);
  std::gamma_distribution<float> gamma(noise > 0 ? static_cast<float>(1 / (noise * noise)) : 1.0f,
                                       static_cast<float>(noise * noise));
  std::vector<float>& direct = film.layer("direct", {"R", "G", "B"}, true).pixels;
  std::vector<float>& indirect = film.layer("indirect", {"R", "G", "B"}, true).pixels;
  std::vector<float>& depth = film.layer("depth", {"Y"}).pixels;
  direct.resize(film.pixel_count() * 3);
  indirect.resize(film.pixel_count() * 3);
  depth.resize(film.pixel_count());
  for (uint32_t y = 0; y < size.height; ++y) {
    for (uint32_t x = 0; x < size.width; ++x) {
      const double u = (x + 0.5) / size.width, v = (y + 0.5) / size.height;
      const size_t i = size_t{y} * size.width + x;
      const double disc = std::hypot(u - 0.5, v - 0.55) < 0.2 + 0.02 * static_cast<double>(scene) ? 1 : 0.25;
      const double lamp = std::abs(u - 0.5) < 0.1 && v < 0.08 ? 40 : 0;
      const double tint = u > 0.6 && v > 0.5 ? 1 + bias : 1;
      const float spread = noise > 0 ? gamma(generator) : 1.0f, other = noise > 0 ? gamma(generator) : 1.0f;
      for (int c = 0; c < 3; ++c) {
        const double albedo = 0.3 + 0.5 * std::abs(std::sin(6 * u + c + static_cast<double>(scene)));
        direct[3 * i + c] = static_cast<float>(lamp + albedo * disc * (1.2 - v)) * (lamp > 0 ? 1.0f : spread);
        indirect[3 * i + c] = static_cast<float>(0.3 * albedo * tint * (0.4 + v)) * other;
      }
      depth[i] = static_cast<float>(1 + 3 * v);
    }
  }
  return film;
}

inline nlohmann::ordered_json example_summary(size_t scene, size_t variant, size_t seeds) {
  const double error = 0.02 / std::pow(3.0, static_cast<double>(variant)) * (1 + 0.3 * static_cast<double>(scene));
  const auto mean = [](double value) {
    return nlohmann::ordered_json{{"mean", value}, {"low", value / 1.3}, {"high", value * 1.3}};
  };
  nlohmann::ordered_json s = {{"scene", scene},
                              {"variant", variant},
                              {"budget", 0},
                              {"seeds", seeds},
                              {"metrics", {{"relMSE", mean(error)}, {"FLIP", mean(std::sqrt(error))}}},
                              {"prepare_seconds", 0.2},
                              {"iterate_seconds", 4.0},
                              {"compile_seconds", 1.0},
                              {"device_seconds", 3.5},
                              {"processor_seconds", 7.0},
                              {"samples", 64 << variant},
                              {"peak_host_bytes", 4e8},
                              {"peak_device_bytes", 6e7},
                              {"debiased_mse", error},
                              {"resolved", variant != 2},
                              {"slope", {{"value", -0.97}, {"low", -1.1}, {"high", -0.9}}},
                              {"bias",
                               {{"mse", 1e-4},
                                {"mse_standard_error", 1e-5},
                                {"standard_errors", variant == 1 ? 5.2 : 0.9},
                                {"variance_mse", 2e-4}}}};
  for (double t = 0.25; t <= 4; t *= std::sqrt(2.0)) {
    s["curve"].push_back({{"seconds", t}, {"samples", 16 * t}, {"relmse", mean(error * 4 / t)}});
    s["processor_curve"].push_back(
        {{"processor_seconds", 1.75 * t}, {"samples", 16 * t}, {"relmse", mean(error * 4 / t)}});
  }
  s["time_to_error"] = {{{"relmse", 0.1}, {"seconds", mean(0.3)}, {"at_most", true}}, {{"relmse", 1e-4}}};
  s["processor_time_to_error"] = {{{"relmse", 0.1}, {"processor_seconds", mean(0.525)}, {"at_most", true}},
                                  {{"relmse", 1e-4}}};
  return s;
}

/// One piece with its image.
inline nlohmann::ordered_json example_piece(const std::filesystem::path& folder, const ReportExample& example,
                                            size_t scene, size_t variant, uint32_t seed) {
  const double noise = 0.5 / std::pow(1.7, static_cast<double>(variant));
  const std::string image = fmt::format("pieces/scene{}-variant{}-budget1-seed{}.exr", scene + 1, variant + 1, seed);
  write_exr(folder / image,
            example_film(example, scene, noise, variant == 1 ? 0.3 : 0, seed + 100 * static_cast<uint32_t>(variant)));
  return {{"scene", scene},
          {"variant", variant},
          {"budget", 0},
          {"seed", seed},
          {"image", image},
          {"parameters", "name=x,points=16"},
          {"planned", "points 64 -> 16"},
          {"iterations", 64},
          {"samples", 64},
          {"passes",
           {{{"name", "closest hit"}, {"device_seconds", 2.0}, {"count", 64}},
            {{"name", "shade"}, {"device_seconds", 1.5}, {"count", 64}}}},
          {"converged", false}};
}

/// An experiment of no paper with a plot, whose second line has the hostile label and whose third has no point.
inline nlohmann::ordered_json example_reproduction(const ReportExample& example) {
  using nlohmann::ordered_json;
  ordered_json lines = ordered_json::array();
  for (size_t v = 0; v < 3; ++v) {
    ordered_json points = ordered_json::array();
    for (const double x : {1e3, 1e4, 1e5}) {
      if (v < 2) points.push_back({{"x", x}, {"y", 1e-4 * x}});
    }
    lines.push_back({{"label", v == 1 ? example.hostile : fmt::format("technique_{}", v + 1)}, {"points", points}});
    if (v < 2) lines.back()["slope"] = 1;
  }
  return {
      {"id", "lucarium/growth"},
      {"title", example.hostile},
      {"place", "slopes"},
      {"claim", example.hostile},
      {"differences", ""},
      {"quick", true},
      {"own", true},
      {"values", {{{"label", example.hostile}, {"unit", "s"}, {"ours", 2}}, {{"label", "not there"}, {"unit", ""}}}},
      {"plots", {{{"title", "Growth"}, {"x_label", "triangles"}, {"y_label", "time [s]"}, {"lines", lines}}}},
      {"trends", {{{"claim", example.hostile}, {"expression", "1 < 2"}, {"verdict", "holds"}}}}};
}

/// Writes the whole folder: seed 2 of the last variant fails, the first scene refuses the last variant when there are
/// two scenes, and the last scene, after the others, cannot be loaded.
inline void write_report_example(const std::filesystem::path& folder, const ReportExample& example = {}) {
  using nlohmann::ordered_json;
  for (const char* name : {"pieces", "references", "means"}) std::filesystem::create_directories(folder / name);
  ordered_json results = {{"schema", "lucarium-results-2"},
                          {"version", "0.1.0"},
                          {"device", "test device"},
                          {"driver", "1"},
                          {"started", "2026-01-01T00:00:00Z"},
                          {"interrupted", true},
                          {"machine", {{"cpu", "test"}, {"logical_cores", 2}}},
                          {"comparison", {{"size", {example.width, example.height}}, {"seeds", example.seeds}}}};
  results["budgets"] = ordered_json::array({{{"label", "4 s"}, {"seconds", 4}}});
  results["metrics"] = {{{"name", "relMSE"}, {"formula", "<(x-r)^2/(r^2+.01Y^2)>"}, {"unit", ""}, {"better", "lower"}},
                        {{"name", "FLIP"}, {"formula", "Andersson et al. 2020"}, {"unit", ""}, {"better", "lower"}}};
  for (const char* key : {"variants", "scenes", "pieces", "summaries", "pairs", "winners", "gates"})
    results[key] = ordered_json::array();
  for (size_t v = 0; v < example.variants; ++v) {
    results["variants"].push_back({{"label", v == 1 ? example.hostile : fmt::format("technique_{}", v + 1)},
                                   {"technique", "t"},
                                   {"parameters", {{"name", example.hostile}, {"points", "64"}}},
                                   {"given", {"name"}},
                                   {"summary", example.hostile},
                                   {"citation", "none"},
                                   {"version", "1"}});
  }
  for (size_t s = 0; s < example.scenes; ++s) {
    const std::string image = fmt::format("references/scene{}-set1.exr", s + 1);
    write_exr(folder / image, example_film(example, s, 0, 0, 1));
    ordered_json scene = {{"name", fmt::format("scene {}", s + 1)},
                          {"triangles", 1234},
                          {"hash", "abc"},
                          {"exposure_stops", 0.5},
                          {"unlike_machines", s == 1},
                          {"warnings", ordered_json::array({example.hostile})}};
    scene["references"] = ordered_json::array({{{"path_set", "max_bounces=3"},
                                                {"image", image},
                                                {"source", "path_tracing"},
                                                {"samples", 4096},
                                                {"own_relmse", 1e-4}}});
    scene["variants"] = ordered_json::array();
    for (size_t v = 0; v < example.variants; ++v) {
      ordered_json entry = {{"reference", 0}, {"limitations", ordered_json::array({"no caustics"})}};
      const bool refused = s == 0 && v + 1 == example.variants && example.scenes == 2;
      if (refused) entry["refused"] = example.hostile;
      scene["variants"].push_back(entry);
      if (refused) continue;
      for (uint32_t seed = 1; seed <= example.seeds; ++seed) {
        if (seed == 2 && v + 1 == example.variants) {
          results["pieces"].push_back({{"scene", s},
                                       {"variant", v},
                                       {"budget", 0},
                                       {"seed", seed},
                                       {"failure", "killed by signal 9: " + example.hostile}});
        } else {
          results["pieces"].push_back(example_piece(folder, example, s, v, seed));
        }
      }
      if (example.seeds > 1) {
        write_exr(folder / fmt::format("means/scene{}-variant{}-budget1.exr", s + 1, v + 1),
                  example_film(example, s, 0.2, v == 1 ? 0.3 : 0, 77));
      }
      results["summaries"].push_back(example_summary(s, v, example.seeds));
      if (v > 0) {
        results["pairs"].push_back({{"scene", s},
                                    {"budget", 0},
                                    {"a", 0},
                                    {"b", v},
                                    {"metric", "relMSE"},
                                    {"ratio", {{"mean", 3.0}, {"low", 2.0}, {"high", 4.5}}},
                                    {"different", true}});
      }
      if (v == 1) {
        results["winners"].push_back({{"scene", s},
                                      {"budget", 0},
                                      {"best", 1},
                                      {"next", 0},
                                      {"metric", "relMSE"},
                                      {"ratio", {{"mean", 3.0}, {"low", 0.9}, {"high", 4.5}}},
                                      {"different", s > 0}});
      }
      results["gates"].push_back(
          {{"gate", "relMSE<0.01"}, {"scene", s}, {"variant", v}, {"budget", 0}, {"value", 0.02}, {"passed", v > 0}});
    }
    results["scenes"].push_back(std::move(scene));
  }
  results["scenes"].push_back({{"name", "broken.glb"}, {"failure", "no such file: " + example.hostile}});
  results["reproduction"] = example_reproduction(example);
  results["baseline"] = {{"folder", "old"},
                         {"version", "0.0.9"},
                         {"missing", ordered_json::array()},
                         {"changes", ordered_json::array({{{"scene", 0},
                                                           {"variant", 0},
                                                           {"budget", 0},
                                                           {"metric", "relMSE"},
                                                           {"ratio", 0.5},
                                                           {"low", 0.4},
                                                           {"high", 0.6},
                                                           {"verdict", "better"}}})}};
  write_file_atomically(folder / "results.json", results.dump());
}

}  // namespace lucarium::test
