// SPDX-License-Identifier: Apache-2.0
#include "outputs/atlas_pictures.h"

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/film/image_io.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/surface_atlas/image.h"
#include "lucarium/technique/technique.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace {

void write(const std::filesystem::path& file, const Film& film) {
  if (file.extension() == ".png") return write_png(file, film);
  write_exr(file, film);
}

/// The scene from its camera, every texel in its colour.
Film draw_view(const SurfaceAtlas& atlas, Device& device, KernelScheduler& scheduler, const Scene& scene,
               const SceneBuffers& buffers, const std::string& size) {
  RenderSettings settings;
  std::tie(settings.width, settings.height) = parse_size(size);
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.at(0);
  const Bvh bvh(device, scene, buffers);
  GBuffer gbuffer(device, scheduler, buffers, bvh, make_frame(settings), "atlas view");
  if (!gbuffer.render(0)) throw Error(ErrorClass::interrupted, "interrupted");
  Film film(settings.width, settings.height);
  film.layer("atlas").additive = true;
  atlas.resolve(gbuffer.points(), film);
  return film;
}

}  // namespace

void AtlasArguments::add_to(Command command) {
  command.option("--atlas", charts).default_text("none");
  command.option("--atlas-view", view).default_text("none");
  command.option("--atlas-texels", options.texel_count).check(positive_number()).capture_default_str();
  command.option("--atlas-edge", options.texel_edge).check(positive_number()).default_text("by --atlas-texels");
  command.flag("--atlas-texcoord1", options.use_texcoord1);
  command.option("--size", size).capture_default_str();
  device.add_to(command);
  command.needs({"--atlas-texels", "--atlas-edge", "--atlas-texcoord1"}, {"--atlas", "--atlas-view"});
  command.needs(device_option_names(), {"--atlas", "--atlas-view"});
  command.needs({"--size"}, {"--atlas-view"});
  command.excludes({"--atlas-texels"}, {"--atlas-edge"});
}

void AtlasArguments::check(bool overwrite) const {
  if (!charts.empty() && !view.empty()) check_distinct({charts, view});
  for (const std::filesystem::path& file : {charts, view}) {
    if (file.empty()) continue;
    check_image_name(file);
    check_output(file, overwrite);
  }
  parse_size(size);
}

std::optional<SurfaceAtlasReport> draw_atlas(const AtlasArguments& arguments, const Scene& scene, bool quiet) {
  if (arguments.charts.empty() && arguments.view.empty()) return std::nullopt;
  const std::shared_ptr<Device> device = Device::open(arguments.device.resolved());
  KernelScheduler scheduler(device);
  const SceneBuffers buffers(*device, scene);
  SurfaceAtlasOptions options = arguments.options;
  Progress progress("surface atlas", quiet ? Progress::Style::quiet : Progress::Style::automatic);
  options.progress = [&](double fraction, const std::string& stage) { progress.update(fraction, stage); };
  const SurfaceAtlas atlas(*device, scheduler, scene, buffers, options, "surface atlas");
  if (!arguments.charts.empty()) write(arguments.charts, SurfaceAtlasImage(atlas).draw(atlas));
  if (!arguments.view.empty()) {
    write(arguments.view, draw_view(atlas, *device, scheduler, scene, buffers, arguments.size));
  }
  return atlas.report();
}

std::string text_of(const SurfaceAtlasReport& r) {
  return fmt::format(
      "surface atlas: {} texel sides on {} texels in {} charts ({} of one texel), {} cells, texel edge {:.4g} m\n"
      "  area {:.6g} m², per texel over edge² (5, 50, 95 %): {:.2f} {:.2f} {:.2f}; {}; {:.2f} s\n",
      r.sides, r.texels, r.charts, r.one_texel_charts, r.cells, r.texel_edge, r.area, r.area_p5, r.area_p50, r.area_p95,
      format_bytes(r.bytes), r.seconds);
}

std::string with_atlas(const std::string& scene_report, const SurfaceAtlasReport& r) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(scene_report);
  json["atlas"] = {{"sides", r.sides},
                   {"texels", r.texels},
                   {"charts", r.charts},
                   {"one_texel_charts", r.one_texel_charts},
                   {"cells", r.cells},
                   {"texel_edge_m", r.texel_edge},
                   {"area_m2", r.area},
                   {"texel_area_over_edge2_p5", r.area_p5},
                   {"texel_area_over_edge2_p50", r.area_p50},
                   {"texel_area_over_edge2_p95", r.area_p95},
                   {"bytes", r.bytes},
                   {"seconds", r.seconds}};
  return json.dump(2);
}

}  // namespace lucarium::app
