// SPDX-License-Identifier: Apache-2.0
// A scene, its atlas and the exchange along bundles, without the technique around them.
#pragma once
#include <functional>
#include <memory>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/exchange/bundle_transfer.h"
#include "bundle_exchange/pixels/side_state.h"
#include "bundle_exchange/senders/side_means.h"
#include "bundle_exchange/senders/side_preview.h"
#include "bundle_exchange/specular/side_specular.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/bundles/direction_sequence.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/texel_sides/side_accessibility.h"
#include "lucarium/services/texel_sides/side_light.h"
#include "lucarium/services/texel_sides/texel_extent.h"
#include "lucarium/shared/texel_sides.h"

namespace lucarium::test {

/// A box whose walls face inwards, one material for each: -x, +x, -y, +y, -z, +z.
inline Scene box_scene(const std::array<int, 6>& materials, Scene scene = {}) {
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      add_instance(scene, add_mesh(scene, MeshBuilder("wall").box_face({0, 0, 0}, {1, 1, 1}, axis, side, true).take()),
                   materials[2 * axis + side]);
  return scene;
}

class BundleRig {
 public:
  BundleRig(Scene scene, uint64_t texels, float pixel_size, bundle::Channels channels = {},
            bundle::Parameters parameters = {}, std::map<std::string, std::string> defines = {})
      : channels_(channels),
        parameters_(endless(parameters)),
        scene_(std::move(scene)),
        device_(Device::open()),
        scheduler_(device_),
        buffers_(*device_, scene_),
        bvh_(*device_, scene_, buffers_),
        atlas_(*device_, scheduler_, scene_, buffers_, options(texels), "test"),
        program_(make_program(*device_, channels, std::move(defines))),
        interior_(*device_, scheduler_, buffers_, bvh_, atlas_, "bundle_exchange", "lower texels"),
        accessibility_(*device_, buffers_, atlas_,
                       {pixel_size, parameters.access_gap, SideAccessibility::Options{}.rays,
                        SideHalves::per_side(scene_, parameters.access_gap)},
                       "test", "lower texels"),
        light_(*device_, "test", "light samples", accessibility_.side_halves().count),
        means_(*device_, scheduler_, program_, atlas_, accessibility_, light_, channels, parameters_),
        transfer_(*device_, scheduler_, scene_, buffers_, atlas_, means_.records(), interior_, accessibility_, channels,
                  {pixel_size, parameters.transfer, nullptr}) {
    while (!interior_.complete()) interior_.advance();
    accessibility_.begin(*device_, scheduler_, scene_, buffers_, atlas_, interior_, transfer_.raster());
    while (!accessibility_.complete()) accessibility_.advance();
    means_.copy_materials();
    if (!channels.chains) return;
    specular_ = std::make_unique<bundle::SideSpecular>(
        *device_, scheduler_, program_, buffers_, bvh_, atlas_, means_, parameters_, !scene_.lights.empty(),
        channels.self_fed ? -1 : static_cast<int>(channels.reflected()), parameters.transfer == bundle::Transfer::ray);
  }

  // ---- by hand: what texel sides send in channel 0, and what arrives

  void send(const std::function<glm::vec3(uint32_t side)>& radiance) {
    std::vector<float4> values(means_.records().count());
    for (uint32_t side = 0; side < half_count(); ++side)
      values[size_t{side} * 2 * channels_.count] = float4(radiance(side), 0.f);
    TypedBuffer<float4> records = means_.records();
    records.upload(values);
  }
  void run(const DirectionSequence& sequence, uint64_t count) {
    sums_.resize(half_count());
    for (uint64_t i = 0; i < count; ++i) {
      transfer_.exchange(sequence.at(i), static_cast<uint32_t>(i + 1));
      if ((i + 1) % kLongestBatch == 0 || i + 1 == count) take_sums();
    }
  }
  /// xyz: sum of w L of channel 0, w: sum of w, over all that was run.
  const std::vector<glm::dvec4>& sums() const { return sums_; }
  /// Per texel side: what others counted of the rays along which they saw it, over all that was run since send().
  std::vector<double> counted() const {
    std::vector<double> result;
    const std::vector<float4> values = means_.records().download();
    for (uint32_t side = 0; side < half_count(); ++side) result.push_back(values[size_t{side} * 2 * channels_.count].w);
    return result;
  }
  /// E/π of every texel side by `rounds` light samples of its points.
  std::vector<double> sampled_light(uint32_t rounds) {
    SideLight light(*device_, scheduler_, buffers_, bvh_, atlas_, accessibility_, DirectLight::kAllLights, "test",
                    "lower texels", true);
    light.reset(1);
    for (uint32_t i = 0; i < rounds; ++i) {
      light.sample();
      light.commit();
    }
    scheduler_.finish();
    std::vector<double> result = red(light.light_samples());
    for (double& value : result) value /= 3.14159265358979323846;
    return result;
  }

  // ---- as the technique does it

  /// The direct irradiance of every texel side.
  void set_direct(float irradiance) {
    light_.upload(std::vector<float4>(half_count(), float4(irradiance, irradiance, irradiance, 1)));
  }
  void set_direct(const std::function<float(uint32_t side)>& irradiance) {
    std::vector<float4> values;
    for (uint32_t side = 0; side < half_count(); ++side) {
      const float e = irradiance(side);
      values.emplace_back(e, e, e, 1.f);
    }
    light_.upload(values);
  }
  /// Directions `begin` … `end - 1` in batches of Parameters::batch.
  void solve(const DirectionSequence& sequence, uint64_t end, uint64_t begin = 0) {
    const uint64_t batch = static_cast<uint64_t>(parameters_.batch);
    for (uint64_t first = begin; first < end; first += batch) {
      means_.make_senders();
      const bool direct_only = means_.direct_only(first);
      if (state_ && !direct_only) state_->add_balance();
      bundle::SideSpecular* specular = direct_only ? nullptr : specular_.get();
      if (specular) specular->begin_batch(sequence, first, static_cast<uint32_t>(batch));
      for (uint64_t i = first; i < first + batch; ++i) {
        const uint32_t seed = static_cast<uint32_t>(i + 1) * 0x9e3779b9u;
        if (specular) specular->send(sequence.at(i), static_cast<uint32_t>(i - first), seed, means_.sends_direct());
        direct_only ? transfer_.exchange_emission(sequence.at(i), seed) : transfer_.exchange(sequence.at(i), seed);
        if (specular) specular->receive(static_cast<uint32_t>(i - first));
        if (specular && state_) state_->add_history();
      }
      if (specular) specular->commit();
      means_.commit(first, static_cast<uint32_t>(batch));
    }
    scheduler_.finish();
  }
  /// Watches the state of texel sides from now on.
  const bundle::SideState& watch() {
    state_ =
        std::make_unique<bundle::SideState>(*device_, scheduler_, means_, accessibility_.shares(), specular_.get());
    return *state_;
  }
  const bundle::SideMeans& means() const { return means_; }
  const bundle::SideSpecular& specular() const { return *specular_; }
  /// Red of indirect and of exchanged direct irradiance over π, per texel side.
  std::vector<double> indirect() const { return red(means_.shown()); }
  std::vector<double> direct() const { return red(means_.shown_direct()); }
  /// What SidePreview makes of values that have the given variance each (after solve()).
  std::vector<double> smooth(const std::vector<float>& values, float variance) {
    std::vector<float4> shown, statistics(half_count(), float4(variance, 0, 0, 1));
    for (const float v : values) shown.emplace_back(v, v, v, 1.f);
    TypedBuffer<float4> shown_buffer = means_.shown(), statistics_buffer = means_.statistics();
    shown_buffer.upload(shown);
    statistics_buffer.upload(statistics);
    bundle::SidePreview preview(*device_, scheduler_, program_, atlas_, means_);
    preview.smooth();
    scheduler_.finish();
    return red(preview.shown());
  }
  /// Forgets what was solved.
  void reset() { means_.reset(); }
  double relative_error() const { return means_.relative_error(); }
  float4 balance() const { return means_.balance(); }
  /// Area-weighted mean over texel sides that `counts`.
  double mean(const std::vector<double>& values, const std::function<bool(uint32_t)>& counts = {}) const {
    const std::vector<AtlasTexel> all = texels();
    double sum = 0, area = 0;
    for (uint32_t side = 0; side < sides(); ++side) {
      if (counts && !counts(side)) continue;
      sum += all[side].area * values[side];
      area += all[side].area;
    }
    return sum / area;
  }

  double bundle_pixel() const { return transfer_.pixel(); }  ///< edge [m]
  /// What the bundle image's pixels would be when the texels have followed a change, as they do in a warm start [m].
  double bundle_pixel_after(const std::function<SceneChange(Scene&)>& change_scene) {
    const SceneChange change = change_scene(scene_);
    buffers_.update(scene_, change);
    atlas_.refit(scene_, change);
    return SideAccessibility(*device_, buffers_, atlas_, {0.5f, parameters_.access_gap}, "test", "lower texels")
        .safe_pixel();
  }
  double texel_edge() const { return static_cast<double>(atlas_.info().texel_edge); }
  double texel_extent(double limit) const { return largest_texel_extent(atlas_, buffers_, limit); }
  /// Largest distance of two sample points of a texel side, SIDE_POINTS each.
  double sampled_extent() const {
    const std::vector<AtlasSample> samples = atlas_.samples().download();
    const auto triangles = buffers_.scene_triangles.download();
    const auto vertices = buffers_.scene_vertices.download();
    const auto point = [&](const AtlasSample& s) {
      const auto corner = [&](uint32_t v) {
        return glm::vec3(vertices[v].position.x, vertices[v].position.y, vertices[v].position.z);
      };
      const glm::vec3 p = corner(triangles[s.triangle].v0);
      return p + s.b1 * (corner(triangles[s.triangle].v1) - p) + s.b2 * (corner(triangles[s.triangle].v2) - p);
    };
    float result = 0;
    for (size_t side = 0; side < sides(); ++side)
      for (uint32_t i = 0; i < SIDE_POINTS; ++i)
        for (uint32_t j = 0; j < i; ++j)
          result = std::max(
              result, glm::length(point(samples[side * SIDE_POINTS + i]) - point(samples[side * SIDE_POINTS + j])));
    return static_cast<double>(result);
  }
  uint32_t sides() const { return atlas_.info().texel_count; }
  /// In scenes with glass what is said of each side above holds of each half: first of all open ones, then of all
  /// covered ones. As many as sides otherwise.
  uint32_t half_count() const { return means_.halves().count; }
  /// Their areas times accessibility [m²].
  std::vector<double> half_areas() const {
    const std::vector<AtlasTexel> all = texels();
    std::vector<double> result;
    for (const float share : accessibility())
      result.push_back(double{share} * double{all[result.size() % sides()].area});
    return result;
  }
  std::vector<AtlasTexel> texels() const { return atlas_.texels().download(); }
  std::vector<float2> interior() const { return interior_.shares().download(); }
  std::vector<float> accessibility() const { return accessibility_.shares().download(); }
  std::vector<uint32_t> point_levels() const { return accessibility_.points().download(); }
  std::vector<SurfacePoint> points() const { return atlas_.surface_points().download(); }
  std::vector<AtlasMaterial> materials() const { return atlas_.materials().download(); }
  /// Instance that a world triangle belongs to.
  uint32_t instance_of(uint32_t triangle) const {
    return buffers_.scene_triangles.download(triangle, 1).front().instance;
  }

 private:
  /// Records are for a batch. Over 8192 directions single precision would round every addition of a like w to the same
  /// side, by up to 1e-3 of it.
  static constexpr uint64_t kLongestBatch = 64;
  void take_sums() {
    scheduler_.finish();
    TypedBuffer<float4> records = means_.records();
    std::vector<float4> values = records.download();
    for (uint32_t side = 0; side < half_count(); ++side) {
      float4& batch = values[size_t{side} * 2 * channels_.count + 1];
      sums_[side] += glm::dvec4(batch.x, batch.y, batch.z, batch.w);
      batch = float4{};
    }
    records.upload(values);
  }
  static SurfaceAtlasOptions options(uint64_t texels) {
    SurfaceAtlasOptions result;
    result.texel_count = texels;
    result.samples = SIDE_POINTS;
    return result;
  }
  /// solve() says how many directions there are.
  static bundle::Parameters endless(bundle::Parameters parameters) {
    parameters.stop_error = 0;
    return parameters;
  }
  static Program make_program(Device& device, const bundle::Channels& channels,
                              std::map<std::string, std::string> defines) {
    for (const auto& [name, value] : channels.defines()) defines[name] = value;
    return bundle::make_technique_program(device, std::move(defines));
  }
  static std::vector<double> red(const TypedBuffer<float4>& values) {
    std::vector<double> result;
    for (const float4& v : values.download()) result.push_back(v.w > 0 ? v.x / v.w : 0.f);
    return result;
  }
  bundle::Channels channels_;
  bundle::Parameters parameters_;
  Scene scene_;
  std::shared_ptr<Device> device_;
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  Bvh bvh_;
  SurfaceAtlas atlas_;
  Program program_;
  TexelInterior interior_;
  SideAccessibility accessibility_;
  TypedBuffer<float4> light_;
  bundle::SideMeans means_;
  bundle::BundleTransfer transfer_;
  std::unique_ptr<bundle::SideSpecular> specular_;
  std::unique_ptr<bundle::SideState> state_;
  std::vector<glm::dvec4> sums_;
};

}  // namespace lucarium::test
