// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/layout/grow.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>

#include "lucarium/services/surface_atlas/layout/chart.h"
#include "lucarium/services/surface_atlas/layout/texcoord.h"

namespace lucarium {

namespace {

constexpr double cone_degrees = 38;
constexpr double texel_normal_degrees = 75;
constexpr float deviation_steps = 256;  // of 1 - cos: within one step the nearer triangle comes first
constexpr uint32_t tick_interval = 1u << 15;

/// Grows sets from the largest free triangle on.
class Grower {
 public:
  Grower(const AtlasMesh& mesh, const std::vector<double>& texcoord_scale, const std::function<void(double)>& tick)
      : mesh_(mesh), texcoord_scale_(texcoord_scale), tick_(tick), chart_of_(mesh.triangle_count(), LUCARIUM_NONE) {}

  uint32_t run();
  std::vector<uint32_t>& chart_of() { return chart_of_; }

 private:
  /// Flattest first, then nearest to the seed, then the lowest index.
  using Candidate = std::tuple<int, float, uint32_t>;
  void grow(uint32_t seed, uint32_t chart);
  void offer_neighbors(uint32_t triangle, uint32_t seed);
  glm::vec3 center(uint32_t t) const {
    return glm::vec3((mesh_.position(t, 0) + mesh_.position(t, 1) + mesh_.position(t, 2)) / 3.);
  }

  const AtlasMesh& mesh_;
  const std::vector<double>& texcoord_scale_;
  const std::function<void(double)>& tick_;
  std::vector<uint32_t> chart_of_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> open_;
  glm::vec3 seed_center_{0}, axis_{0};
};

uint32_t Grower::run() {
  std::vector<uint32_t> order(mesh_.triangle_count());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const bool flat_a = mesh_.normal[a] != glm::vec3(0), flat_b = mesh_.normal[b] != glm::vec3(0);
    return flat_a != flat_b ? flat_a : mesh_.area[a] > mesh_.area[b];
  });
  uint32_t charts = 0, until_tick = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (until_tick-- == 0) {
      tick_(double(i) / double(order.size()));
      until_tick = tick_interval;
    }
    if (chart_of_[order[i]] == LUCARIUM_NONE && !mesh_.left_out[order[i]]) grow(order[i], charts++);
  }
  return charts;
}

void Grower::grow(uint32_t seed, uint32_t chart) {
  seed_center_ = center(seed);
  axis_ = mesh_.normal[seed];
  chart_of_[seed] = chart;
  offer_neighbors(seed, seed);
  while (!open_.empty()) {
    const uint32_t triangle = std::get<2>(open_.top());
    open_.pop();
    if (chart_of_[triangle] != LUCARIUM_NONE) continue;
    chart_of_[triangle] = chart;
    offer_neighbors(triangle, seed);
  }
}

void Grower::offer_neighbors(uint32_t triangle, uint32_t seed) {
  static const float cone = static_cast<float>(cos_degrees(cone_degrees));
  const bool island = !texcoord_scale_.empty() && texcoord_scale_[mesh_.geometry.instance[seed]] > 0;
  for (int i = 0; i < 3; ++i) {
    const uint32_t other = mesh_.neighbor[triangle][i];
    if (other == LUCARIUM_NONE || chart_of_[other] != LUCARIUM_NONE) continue;
    if (island) {
      if (texcoord1_goes_on(mesh_, triangle, i, other)) open_.emplace(0, 0.f, other);
      continue;
    }
    if (mesh_.hard[triangle] >> i & 1) continue;
    const bool sliver = mesh_.normal[other] == glm::vec3(0) || axis_ == glm::vec3(0);
    const float cosine = sliver ? 1.f : glm::dot(axis_, mesh_.normal[other]);
    if (cosine < cone) continue;
    const glm::vec3 away = center(other) - seed_center_;
    open_.emplace(static_cast<int>((1 - cosine) * deviation_steps), glm::dot(away, away), other);
  }
}

/// What decides whether small sets make one texel together.
struct Patch {
  double area = 0;
  glm::dvec3 low{INFINITY}, high{-INFINITY}, normal{0};  ///< normal: weighted by area
  void add(const Patch& p) {
    area += p.area;
    low = glm::min(low, p.low), high = glm::max(high, p.high);
    normal += p.normal;
  }
  bool small(double edge) const { return area <= edge * edge && glm::length(high - low) <= 2 * edge; }
};

bool normals_agree(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::dot(a, b) >= cos_degrees(texel_normal_degrees) * glm::length(a) * glm::length(b);
}

/// Joins adjacent small sets, longest common edge first. Returns each set's representative and which are texels.
std::vector<uint32_t> join_small(const AtlasMesh& mesh, const std::vector<uint32_t>& chart_of, uint32_t charts,
                                 double edge, std::vector<uint8_t>& small) {
  std::vector<Patch> patches(charts);
  for (uint32_t t = 0; t < chart_of.size(); ++t) {
    if (mesh.left_out[t]) continue;
    Patch one;
    one.area = mesh.area[t];
    one.normal = mesh.area[t] * glm::dvec3(mesh.normal[t]);
    for (int i = 0; i < 3; ++i)
      one.low = glm::min(one.low, mesh.position(t, i)), one.high = glm::max(one.high, mesh.position(t, i));
    patches[chart_of[t]].add(one);
  }
  small.resize(charts);
  for (uint32_t c = 0; c < charts; ++c) small[c] = patches[c].small(edge);
  std::vector<std::tuple<float, uint32_t, uint32_t>> borders;  // minus length, sets
  for (uint32_t t = 0; t < chart_of.size(); ++t) {
    if (mesh.left_out[t] || !small[chart_of[t]]) continue;
    for (int i = 0; i < 3; ++i) {
      const uint32_t other = mesh.neighbor[t][i];
      if (other == LUCARIUM_NONE || other < t || chart_of[other] == chart_of[t] || !small[chart_of[other]]) continue;
      const float length = static_cast<float>(glm::length(mesh.position(t, (i + 1) % 3) - mesh.position(t, i)));
      borders.emplace_back(-length, chart_of[t], chart_of[other]);
    }
  }
  std::sort(borders.begin(), borders.end());
  std::vector<uint32_t> root(charts);
  std::iota(root.begin(), root.end(), 0u);
  for (const auto& [length, first, second] : borders) {
    const uint32_t a = find_root(root, first), b = find_root(root, second);
    if (a == b || !normals_agree(patches[a].normal, patches[b].normal)) continue;
    Patch both = patches[a];
    both.add(patches[b]);
    if (!both.small(edge)) continue;
    patches[std::min(a, b)] = both;
    root[std::max(a, b)] = std::min(a, b);
  }
  for (uint32_t c = 0; c < charts; ++c) root[c] = find_root(root, c);
  return root;
}

}  // namespace

GrownCharts grow_charts(const AtlasMesh& mesh, const std::vector<double>& texcoord_scale,
                        const std::function<void(double)>& tick) {
  Grower grower(mesh, texcoord_scale, tick);
  GrownCharts grown;
  grown.count = grower.run();
  grown.chart_of = std::move(grower.chart_of());
  return grown;
}

ChartSets join_small_charts(const AtlasMesh& mesh, const GrownCharts& grown, double edge) {
  std::vector<uint8_t> small;
  const std::vector<uint32_t> root = join_small(mesh, grown.chart_of, grown.count, edge, small);

  // Sets in order of their representatives, triangles ascending: a counting sort.
  ChartSets sets;
  std::vector<uint32_t> number(grown.count, LUCARIUM_NONE), set_of;
  for (uint32_t c = 0; c < grown.count; ++c) {
    if (root[c] != c) continue;
    number[c] = static_cast<uint32_t>(sets.count());
    sets.one_texel.push_back(small[c]);
  }
  sets.first.assign(sets.count() + 1, 0);
  for (const uint32_t chart : grown.chart_of) {
    set_of.push_back(chart == LUCARIUM_NONE ? LUCARIUM_NONE : number[root[chart]]);
    if (chart != LUCARIUM_NONE) ++sets.first[set_of.back() + 1];
  }
  std::partial_sum(sets.first.begin(), sets.first.end(), sets.first.begin());
  std::vector<uint32_t> next(sets.first.begin(), sets.first.end() - 1);
  sets.triangles.resize(sets.first.back());
  for (uint32_t t = 0; t < set_of.size(); ++t)
    if (set_of[t] != LUCARIUM_NONE) sets.triangles[next[set_of[t]]++] = t;
  return sets;
}

}  // namespace lucarium
