// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/layout.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/parallel.h"
#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/grow.h"
#include "lucarium/services/surface_atlas/layout/table.h"
#include "lucarium/services/surface_atlas/layout/texcoord.h"

namespace lucarium {

namespace {

constexpr int attempts = 4;               // at texel edges, until the wanted count is met
constexpr int max_attempts = 12;          // while there are too many, so that estimate.h can say how many there will be
constexpr double count_tolerance = 1.08;  // within which a count counts as met
constexpr double too_many = 9. / 8;
constexpr double free_slivers =
    1. / 8;                   // of the wanted count: texels of slivers that other texels need not make up for
constexpr size_t parts = 64;  // independent of the number of threads, and so is the result

void check(const AtlasLayoutOptions& options) {
  if (options.texel_edge < 0 || !std::isfinite(options.texel_edge))
    throw_error(ErrorClass::usage, "surface atlas: the texel edge {} m must be finite and not negative",
                options.texel_edge);
  if (options.texel_edge == 0 && options.texel_count == 0)
    throw_error(ErrorClass::usage, "surface atlas: give a number of texels or a texel edge above 0");
  if (!(options.merge_threshold >= 0 && options.merge_threshold <= 1)) {
    throw_error(ErrorClass::usage, "surface atlas: the merge threshold {} is outside 0 to 1", options.merge_threshold);
  }
}

/// Area of all reflecting sides [m²].
double side_area(const AtlasMesh& mesh) {
  double sum = 0;
  for (uint32_t t = 0; t < mesh.triangle_count(); ++t) sum += mesh.area[t] * (mesh.two_sided(t) ? 2 : 1);
  return sum;
}

/// Texels that count towards the wanted number. Those of slivers come on top, up to a share of it, since coarser texels
/// would hardly be fewer of them (slivers that touch nothing are as many at any edge). Beyond it they count at most as
/// much as the others, which thus keep at least half of their number; or in full, where slivers are the scene.
double charged_count(const SideCount& count, double wanted, bool of_slivers) {
  const double others = double(count.all - count.slivers);
  const double beyond = std::max(0., double(count.slivers) - free_slivers * wanted);
  return others + (of_slivers ? beyond : std::min(beyond, others));
}

/// Checks for cancellation and reports progress.
class Watch {
 public:
  explicit Watch(const AtlasLayoutOptions& options) : options_(options) {}
  void at(double fraction, const char* stage) const {
    if (options_.cancelled && options_.cancelled()) {
      throw Error(ErrorClass::interrupted, "surface atlas: cancelled while it was built");
    }
    if (options_.progress) options_.progress(fraction, stage);
  }

 private:
  const AtlasLayoutOptions& options_;
};

std::vector<AtlasPart> place_charts(const AtlasMesh& mesh, const ChartSets& sets, const ChartSettings& settings,
                                    unsigned threads, const std::function<void(double)>& tick) {
  // Runs of sets with about as many triangles each.
  std::vector<size_t> first_set{0};
  const size_t share = sets.triangles.size() / parts + 1;
  for (size_t c = 0; c < sets.count(); ++c)
    if (sets.first[c + 1] - sets.first[first_set.back()] >= share) first_set.push_back(c + 1);
  if (first_set.back() != sets.count()) first_set.push_back(sets.count());
  std::vector<AtlasPart> result(first_set.size() - 1);
  const auto make_worker = [&] {
    return [&, placer = ChartPlacer(mesh, settings)](size_t job) mutable {
      std::vector<uint32_t> triangles;
      for (size_t c = first_set[job]; c < first_set[job + 1]; ++c) {
        triangles.assign(sets.triangles.begin() + sets.first[c], sets.triangles.begin() + sets.first[c + 1]);
        placer.place(triangles, sets.one_texel[c], result[job]);
      }
    };
  };
  parallel_jobs(result.size(), threads, make_worker, [&](size_t job) { tick(double(job) / double(result.size())); });
  return result;
}

}  // namespace

AtlasLayout make_atlas_layout(const AtlasGeometry& geometry, const AtlasLayoutOptions& options) {
  check(options);
  const Watch watch(options);
  watch.at(0, "welding");
  const AtlasMesh mesh(geometry);
  ChartSettings settings;
  settings.merge_threshold = options.merge_threshold;
  settings.texcoord_scale = check_texcoord1(mesh);
  const GrownCharts grown =
      grow_charts(mesh, settings.texcoord_scale, [&](double done) { watch.at(0.1 + 0.2 * done, "growing charts"); });
  const unsigned threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  const double area = side_area(mesh);
  settings.edge = options.texel_edge > 0 ? options.texel_edge : std::sqrt(area / double(options.texel_count));
  if (!(settings.edge > 0)) settings.edge = 1;  // nothing has an area
  std::vector<AtlasPart> best;
  double best_edge = 0, best_off = INFINITY;
  double share = 0.3;  // of the progress; most layouts need one attempt
  for (int attempt = 1; attempt <= max_attempts; ++attempt, share *= 0.5) {
    const ChartSets sets = join_small_charts(mesh, grown, settings.edge);
    std::vector<AtlasPart> placed = place_charts(
        mesh, sets, settings, threads, [&](double done) { watch.at(0.9 - share * (2 - done), "placing charts"); });
    absorb_fragments(mesh, settings, placed);
    const SideCount count = side_count(placed, settings.edge);
    const bool of_slivers = count.sliver_area >= 0.5 * area;
    const double wanted = double(options.texel_count);
    const double ratio = options.texel_edge > 0 ? 1 : charged_count(count, wanted, of_slivers) / wanted;
    const double off = std::fabs(std::log(std::max(ratio, 1e-9)));
    const bool better = off < best_off;
    const bool met = off <= std::log(count_tolerance) || (attempt >= attempts && ratio <= too_many);
    const bool worth_another = ratio > 0 && !met && off < 0.9 * best_off;
    if (better) best = std::move(placed), best_edge = settings.edge, best_off = off;
    if (!worth_another) break;
    settings.edge *= std::sqrt(ratio);
  }
  watch.at(0.9, "joining charts");
  AtlasLayout layout = join_parts(mesh, best, best_edge);
  link_seams(mesh, best, layout);
  fill_empty_cells(layout);
  place_left_out(mesh, layout);
  sample_texels(mesh, layout, options.samples);
  return layout;
}

}  // namespace lucarium
