// SPDX-License-Identifier: Apache-2.0
//
// voxel_abuffer: ray tracing through a coarse voxel grid and three A-buffers
// --------------------------------------------------------------------------
//
// Idea. Rasterize the scene again whenever it has moved, into three orthographic A-buffers, one along each axis, and a
// coarse grid of the voxels that surfaces touch. A ray walks over the grid, and where a voxel is touched over the
// columns of the A-buffer that faces the surface (Hu et al., Ray tracing via GPU rasterization, The Visual Computer 30,
// 2014, section 3). What a rebuild costs depends on pixels and surface area, hardly on triangles, and it runs on the
// device alone.
//
// How. The structure is an Intersector, as the hierarchy of the framework is; the modes are wavefront passes over any.
//
//   cast      C += T a L, T *= 1 − a, over all surfaces along the camera ray, in their order; a is BLEND's alpha
//   whitted   direct light at every vertex, both ideal lobes of mirrors and glass, `depth` of them at most
//   ao        1 − (rays that meet something within the radius) / (all rays), cosine-distributed
//   path      path tracing by the framework's integrator
//
// Composition (algorithm 1): a pass traces λ samples per pixel and adds them to a sum; the image is sum / (λ η) after η
// passes. progressive=on goes on until something changes; off, every frame begins again and ends after `passes` passes.
// With equal seeds both give the same bits.
//
// What is counted. cast and whitted compute the layers `emission` and `direct` (max_bounces 0), path all of them.
//
// Error. Exact search finds the hits of a hierarchy, to the bit. Search by parity loses what is thinner than a pixel,
// and the common wall of solids that touch; hits lie in the planes of their triangles.
//
// Where the paper stands in the source (files below this folder; layered_raster/ is in
// framework/lucarium/services and kernels/lucarium):
//
//   section 3, figure 2, two levels          structure/record_build.cpp: record_build(); structure/state.h
//   section 3.1, three A-buffers             structure/abuffer_lists.cpp: record(), record_packed()
//   section 3.1, geometry shader             structure/grid_layout.cpp: axis_view(): three projections, since a
//                                            triangle is degenerate in a view across its normal
//   section 3.1, linked lists, sorting       layered_raster/lists.cl (list=linked); structure/pack_lists.cl
//   section 3.1, attributes of fragments     structure/store_attributes.cl: abuffer_store_attributes()
//                                            (attributes=stored)
//   section 3.1, voxels from fragments       structure/mark_fragments.cl: abuffer_mark_fragment_voxels()
//                                            (conservative_voxels=off); by triangles: structure/mark_voxels.cl
//   section 3.1, average normal of a voxel   structure/pack_lists.cl: abuffer_pack_parity() (sums);
//                                            structure/choose_axes.cl: abuffer_choose_axes() (axis_rule=average)
//   section 3.2, figure 3, 3D-DDA            search/grid_ray.clh: abuffer_leave(), abuffer_enter()
//   section 3.2, entry and exit P_in, P_out  search/parity_flights.clh: abuffer_read_parity_cells()
//   section 3.2, inside or outside           search/winding.clh: abuffer_winding()
//   section 3.2, 2D-DDA                      search/parity_columns.clh: abuffer_list_way() (search=2d)
//   section 3.2, figure 4, three-step        search/parity_steps.clh: abuffer_cross_points() (search=3): linear
//                                            search, then binary search between P_k-1 and P_k
//   section 3.2, figure 5, one-step          search/parity_steps.clh: abuffer_cross_points() (search=1)
//   section 3.2, shadow rays                 search/parity_hit.clh: abuffer_must_look() (no binary search,
//                                            and of search=3 and 1 no triangle)
//   section 4, deferred shading              modes/primary_raster.cpp: rasterize() (primary=raster)
//   section 4, ray casting, multi-layer      modes/shade_tree_rays.cl: shade_tree_rays() (mode=cast)
//   section 4, Whitted, its rays             reflection rays, refraction rays: modes/shade_tree_rays.cl:
//                                            branch_at_lobe() (mode=whitted); shadow rays: the service direct_light
//   section 4, Whitted, loop for recursion   modes/eye_trees.cpp: grow()
//   section 4, ambient occlusion             modes/occlusion.cl: begin_occlusion_rays() (mode=ao)
//   section 4, path tracing                  modes/path_mode.h (mode=path): the framework's integrator
//   algorithm 1, passes of λ samples         modes/pass_sums.cpp: begin(), commit(); modes/add_pass.cl: add_pass()
//   algorithm 1, PRender(), GRender(), InitCompBuffer()
//   algorithm 1, progressive, general        voxel_abuffer.cpp: step(), begin_frame() (progressive, passes, rebuild)
//   section 5, grid of (√(3n))³ voxels       structure/grid_layout.cpp: choose_grid_size() (not of exact search)
//   section 5.2, regular voxels              compared/trace_voxel.cl (structure=voxel)
//   section 5.2, table 1, octree (SVO)       compared/build_octree.cl, compared/trace_octree.cl (structure=octree)
//   section 6, watertight objects          structure/triangle_classes.h: classify() (closed components)
//   section 6, static and dynamic buffers    moving/moving_set.h (static_set)
//
// Not in the paper: exact search (search/exact_flights.clh) and its (n / 8)³ voxels (structure/grid_layout.cpp),
// search by planes (search/plane_columns.clh), hits moved into their triangles' planes (search/parity_hit.clh), the
// number of surfaces around a point instead of its parity, ends of rays moved off their surfaces
// (search/parity_ray.clh), classes of triangles (structure/triangle_classes.h).

#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"
#include "voxel_abuffer/declaration.h"
#include "voxel_abuffer/modes/occlusion_mode.h"
#include "voxel_abuffer/modes/path_mode.h"
#include "voxel_abuffer/modes/primary_raster.h"
#include "voxel_abuffer/scene_structure.h"

namespace lucarium {
namespace {

using namespace abuffer;

/// Whether a pass is one of an intersector's, by what modes and services call them.
bool traces_rays(const std::string& pass) {
  for (const char* name : {"closest hit", "shadow rays", "BSDF rays", "occlusion rays"})
    if (pass.starts_with(name)) return true;
  return false;
}

class VoxelAbufferTechnique : public TechniqueBase<AbufferParameters> {
 public:
  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    return abuffer::path_set(parameters_, settings);
  }

  double admitted_bias(double declared) const override { return abuffer::admitted_bias(parameters_, declared); }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return abuffer::limitations(parameters_, scene, settings);
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return abuffer::estimate_bytes(parameters_, scene, settings);
  }

  InspectedValues inspect(const SeenPoint& point) const override {
    return structure_ ? structure_->inspect(point) : InspectedValues();
  }

  std::map<std::string, double> counters() const override {
    std::map<std::string, double> all = mode_ ? mode_->counters() : std::map<std::string, double>();
    if (structure_) all.merge(structure_->counters());
    add_seconds(all);
    return all;
  }

 protected:
  void build() override {
    check_parameters(parameters_, settings());
    mode_.reset();  // what refers to memory goes before the memory
    primary_.reset();
    structure_.reset();
    structure_ = std::make_unique<SceneStructure>(scheduler(), scene(), scene_buffers(), parameters_);
    built_for_frame_ = true;
    make_primary();
    make_mode();
  }

  /// Geometry, materials and lights are followed while no buffer that schedules name has been replaced.
  bool follow(const SceneChange& change) override {
    if (!built() || buffers_replaced()) return false;
    if (!change.only_camera()) {
      structure_->update(scene(), change);
      built_for_frame_ = change.geometry();
      if (primary_) primary_->update();
      if (structure_->generation() != structure_generation_) make_mode();
      mode_->follow_scene();
    }
    restart_samples();
    return true;
  }

  void restart() override { begin_frame(); }

  bool step() override {
    if (frame_is_complete()) {
      if (parameters_.progressive) return false;
      begin_frame();
    }
    if (!mode_->pass()) return false;
    ++passes_;
    return true;
  }

  IterationResult state() const override {
    IterationResult result;
    result.samples = passes_ * static_cast<uint64_t>(parameters_.lambda);
    result.converged = frame_is_complete();
    result.progress = parameters_.passes > 0 ? static_cast<double>(passes_) / parameters_.passes : -1;
    result.phase = result.converged ? fmt::format("all {} passes are done", parameters_.passes) : "trace";
    return result;
  }

  void write(Film& film) override { mode_->write(film); }
  void warm_up_kernels() override { mode_->warm_up(); }

 private:
  /// Device seconds of rays, and of all passes but theirs and those of builds; as the profile, since the last change.
  void add_seconds(std::map<std::string, double>& counters) const {
    double rays = 0, other = 0;
    for (const PassProfile& pass : scheduler().profile().passes) {
      if (pass.schedule.starts_with("voxel_abuffer ")) continue;  // builds
      (traces_rays(pass.name) ? rays : other) += pass.device_seconds;
    }
    counters["trace_seconds"] = rays;
    counters["other_seconds"] = other;
  }

  bool frame_is_complete() const {
    return parameters_.passes > 0 && passes_ == static_cast<uint64_t>(parameters_.passes);
  }

  void make_primary() {
    primary_.reset();
    if (rasterizes_primary(parameters_, settings()))
      primary_ = std::make_unique<PrimaryRaster>(scheduler(), scene_buffers(), structure_->intersector(),
                                                 settings().width, settings().height);
  }

  void make_mode() {
    mode_.reset();
    structure_generation_ = structure_->generation();
    const Intersector& intersector = structure_->intersector();
    const ModeContext context{scheduler(), scene_buffers(), intersector, primary_ ? *primary_ : intersector, frame()};
    const auto samples = static_cast<uint32_t>(parameters_.lambda);
    switch (parameters_.mode) {
      case ModeChoice::path: mode_ = std::make_unique<PathMode>(context, path_set(scene(), settings()), samples); break;
      case ModeChoice::occlusion:
        mode_ = std::make_unique<OcclusionMode>(context, samples,
                                                [this] { return occlusion_radius(parameters_, scene()); });
        break;
      default: mode_ = std::make_unique<EyeTrees>(context, tree_options(parameters_));
    }
  }

  /// Empty sums; with rebuild=frame also a new structure, which is the same again.
  void begin_frame() {
    if (parameters_.rebuild == Rebuild::frame && !built_for_frame_) {
      structure_->rebuild();
      if (structure_->generation() != structure_generation_) make_mode();
    }
    built_for_frame_ = false;
    if (rasterizes_primary(parameters_, settings()) != (primary_ != nullptr)) {  // another kind of camera
      mode_.reset();
      make_primary();
      make_mode();
    }
    if (primary_) primary_->rasterize(frame());
    mode_->restart(frame(), full_seed());
    passes_ = 0;
  }

  std::unique_ptr<SceneStructure> structure_;
  std::unique_ptr<PrimaryRaster> primary_;
  uint64_t structure_generation_ = 0;  ///< when the mode was made
  std::unique_ptr<Mode> mode_;
  uint64_t passes_ = 0;           ///< of this frame
  bool built_for_frame_ = false;  ///< the structure was built since the last frame began
};

std::unique_ptr<Technique> create_voxel_abuffer() { return std::make_unique<VoxelAbufferTechnique>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::abuffer::technique_info, lucarium::create_voxel_abuffer)
