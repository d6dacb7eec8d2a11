// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/pixel_inspector.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/view/status.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

ordered_json describe_surface(const PixelSurface& surface) {
  if (!surface.hit) return nullptr;
  return {{"distance", surface.distance},          {"position", to_json(surface.position)},
          {"normal", to_json(surface.normal)},     {"shading", to_json(surface.shading)},
          {"instance", surface.instance},          {"mesh", surface.mesh},
          {"triangle", surface.triangle},          {"material", surface.material},
          {"material_name", surface.material_name}};
}

/// Values of all layers at a pixel; one that is not finite is named.
ordered_json describe_layers(const Film& film, uint32_t x, uint32_t y) {
  ordered_json layers = ordered_json::object();
  const size_t pixel = size_t{std::min(y, film.height() - 1)} * film.width() + std::min(x, film.width() - 1);
  const auto add = [&](const std::string& name, const float* values, size_t count) {
    ordered_json list = ordered_json::array();
    for (size_t c = 0; c < count; ++c)
      list.push_back(std::isfinite(values[c]) ? ordered_json(values[c]) : ordered_json(fmt::format("{}", values[c])));
    layers[name] = std::move(list);
  };
  float image[3] = {};
  for (const FilmLayer& layer : film.layers())
    for (size_t c = 0; layer.additive && c < 3; ++c) image[c] += layer.pixels[3 * pixel + c];
  add("image", image, 3);
  for (const FilmLayer& layer : film.layers())
    add(layer.name, &layer.pixels[layer.channels.size() * pixel], layer.channels.size());
  return layers;
}

}  // namespace

void PixelInspector::look(const ViewSurroundings& around, SceneOnDevice& scene) {
  x_ = std::min(around.request.inspect_x, around.settings.width - 1);
  y_ = std::min(around.request.inspect_y, around.settings.height - 1);
  obstacle_.clear();
  known_ = looked_inside_ = false;
  try {
    surface_ = find_pixel_surface(around.device, scene, around.settings, x_, y_);
    known_ = true;
  } catch (const Error& error) {
    obstacle_ = error.what();
  }
}

/// Reads from the device what a pixel needs, so not at every report.
void PixelInspector::look_inside(const std::array<std::unique_ptr<ViewSide>, view_sides>& sides, uint32_t count,
                                 bool last) {
  if (looked_inside_ && !last && since_inside_.seconds() < 1) return;
  since_inside_.restart();
  looked_inside_ = true;
  for (uint32_t index = 0; index < view_sides; ++index) {
    insides_.at(index).clear();
    RenderSession* const session = index < count && known_ && surface_.hit ? sides.at(index)->whole() : nullptr;
    if (session) insides_.at(index) = session->technique().inspect(surface_.seen);
  }
}

ordered_json PixelInspector::describe(const std::array<std::unique_ptr<ViewSide>, view_sides>& sides, uint32_t count,
                                      bool last) {
  look_inside(sides, count, last);
  ordered_json json = {{"x", x_}, {"y", y_}, {"obstacle", obstacle_}};
  json["known"] = known_;
  json["surface"] = known_ ? describe_surface(surface_) : ordered_json(nullptr);
  json["sides"] = ordered_json::array();
  for (uint32_t index = 0; index < count; ++index) {
    const ViewSide& side = *sides.at(index);
    const Film* const film = side.film();
    if (!film) continue;
    ordered_json insides = ordered_json::array();
    for (const auto& [name, text] : insides_.at(index)) insides.push_back({name, text});
    json["sides"].push_back({{"technique", side.technique().name},
                             {"layers", describe_layers(*film, x_ / side.film_divisor(), y_ / side.film_divisor())},
                             {"insides", std::move(insides)}});
  }
  return json;
}

}  // namespace lucarium
