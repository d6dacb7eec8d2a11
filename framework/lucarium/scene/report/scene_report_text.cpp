// SPDX-License-Identifier: Apache-2.0
// A scene report for people. Declared in scene_report.h.
#include <fmt/ranges.h>

#include "lucarium/base/terminal.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/report/scene_report.h"

namespace lucarium {

namespace {

/// Collects labelled lines.
class Page {
 public:
  void line(std::string_view label, const std::string& value) {
    text_ += fmt::format("{:<14}{}\n", label, printable_line(value));  // names are strangers' texts
  }
  void more(const std::string& value) { line("", value); }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string triple_text(const glm::vec3& v) { return fmt::format("{:.4g} {:.4g} {:.4g}", v.x, v.y, v.z); }

void add_geometry(Page& page, const SceneReport& r) {
  const std::string degenerate =
      r.degenerate_triangles ? fmt::format(", {} without area", r.degenerate_triangles) : std::string();
  page.line("triangles", fmt::format("{} in {} of {}, {} {}{}", r.triangles, counted(r.instances, "instance"),
                                     r.meshes == 1 ? "1 mesh" : fmt::format("{} meshes", r.meshes), r.vertices,
                                     r.vertices == 1 ? "vertex" : "vertices", degenerate));
  const glm::vec3 extent = r.bounds.empty() ? glm::vec3(0) : r.bounds.max - r.bounds.min;
  page.line("bounds", fmt::format("({}) to ({}) m, {:.4g} x {:.4g} x {:.4g} m", triple_text(r.bounds.min),
                                  triple_text(r.bounds.max), extent.x, extent.y, extent.z));
  if (r.deformed_instances) {
    page.line("deformed", fmt::format("{} ({})", counted(r.deformed_instances, "instance"), counted(r.skins, "skin")));
  }
}

void add_materials(Page& page, const SceneReport& r) {
  page.line("materials", std::to_string(r.materials.size()));
  for (const SceneMaterial& m : r.materials) {
    std::string notes;
    if (m.unlit)
      notes += ", unlit";
    else if (m.emits())
      notes += fmt::format(", emits {} cd/m2", triple_text(m.emissive_factor * m.emissive_strength));
    if (m.transmission > 0) notes += fmt::format(", transmits {:.3g}", m.transmission);
    if (m.alpha_mode != AlphaMode::opaque) notes += fmt::format(", {}", alpha_mode_name(m.alpha_mode));
    if (m.double_sided) notes += ", double-sided";
    page.more(fmt::format("{}: base {}{}, metallic {:.3g}, roughness {:.3g}{}", m.name,
                          triple_text(glm::vec3(m.base_color)),
                          m.base_color_texture.texture == none ? "" : " x texture", m.metallic, m.roughness, notes));
  }
  page.line("textures",
            fmt::format("{} of {}, {}", r.textures, counted(r.images, "image"), counted(r.texels, "texel")));
}

void add_lights(Page& page, const SceneReport& r) {
  page.line("lights",
            fmt::format("{} punctual, {}, {}", r.lamps.size(), counted(r.emissive_triangles, "emissive triangle"),
                        r.has_environment ? "an environment" : "no environment"));
  for (const SceneReport::Lamp& lamp : r.lamps) {
    page.more(fmt::format("{} {}: {} {}, flux {} lm", lamp.type, lamp.name, triple_text(lamp.intensity),
                          lamp.type == "directional" ? "lx" : "cd", triple_text(lamp.flux)));
  }
  if (r.emissive_triangles) {
    page.more(fmt::format("emissive triangles: {:.4g} m2, flux {} lm", r.emissive_area, triple_text(r.emissive_flux)));
  }
  if (!r.has_environment) return;
  const std::string size =
      r.environment_width ? fmt::format("{}x{}", r.environment_width, r.environment_height) : std::string("constant");
  page.more(fmt::format("environment {}: mean {} cd/m2", size, triple_text(r.environment_radiance)));
}

void add_views(Page& page, const SceneReport& r) {
  page.line("cameras", std::to_string(r.cameras.size()));
  for (size_t i = 0; i < r.cameras.size(); ++i) {
    const SceneCamera& c = r.cameras[i];
    const std::string kind = c.perspective ? fmt::format("{:.3g} degrees", glm::degrees(c.yfov)) : "orthographic";
    page.more(fmt::format("{} {}: {} at ({})", i, c.name, kind, triple_text(glm::vec3(c.world_from_camera[3]))));
  }
  if (r.camera_path)
    page.line("camera path", fmt::format("{} keys from {:g} to {:g} s, {}", r.camera_path->keys.size(),
                                         r.camera_path->keys.front().seconds, r.camera_path->keys.back().seconds,
                                         interpolation_name(r.camera_path->interpolation)));
  if (!r.camera_path_names.empty()) page.line("paths", fmt::format("{}", fmt::join(r.camera_path_names, ", ")));
  if (!r.animations.empty()) page.line("animations", std::to_string(r.animations.size()));
  for (size_t i = 0; i < r.animations.size(); ++i) {
    const Animation& a = r.animations[i];
    page.more(fmt::format("{} {}: {:.4g} s, {} channels", i, a.name, a.duration, a.channels.size()));
  }
}

}  // namespace

std::string SceneReport::text() const {
  Page page;
  page.line("scene", source);
  add_geometry(page, *this);
  add_materials(page, *this);
  add_lights(page, *this);
  add_views(page, *this);
  if (!extensions_used.empty()) page.line("extensions", fmt::format("{}", fmt::join(extensions_used, ", ")));
  if (!extensions_ignored.empty()) page.line("  ignored", fmt::format("{}", fmt::join(extensions_ignored, ", ")));
  page.line("device memory", format_bytes(device_bytes));
  for (const std::string& warning : warnings) page.line("warning", warning);
  return page.take();
}

}  // namespace lucarium
