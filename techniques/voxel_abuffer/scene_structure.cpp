// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/scene_structure.h"

#include <algorithm>

#include "lucarium/services/bvh/bvh.h"
#include "voxel_abuffer/compared/sparse_octree.h"
#include "voxel_abuffer/compared/triangle_grid.h"
#include "voxel_abuffer/compared/voxel_bits.h"
#include "voxel_abuffer/moving/moving_set.h"
#include "voxel_abuffer/structure/inspect.h"
#include "voxel_abuffer/structure_bytes.h"

namespace lucarium::abuffer {
namespace {

uint32_t pixels_of(const AbufferParameters& parameters) { return static_cast<uint32_t>(parameters.abuffer_size); }
uint32_t voxels_of(const AbufferParameters& parameters) { return static_cast<uint32_t>(parameters.grid_size); }

std::map<std::string, double> counters_of(const VoxelAbufferStatistics& s) {
  return {{"builds", static_cast<double>(s.builds)},
          {"build_seconds", s.build_seconds},
          {"structure_bytes", static_cast<double>(s.bytes)},
          {"fragments", static_cast<double>(s.parity_fragments + s.exact_fragments)},
          {"parity_triangles", s.parity_triangles},
          {"exact_triangles", s.exact_triangles},
          {"open_components", s.open_components},
          {"unbalanced_columns", s.unbalanced_columns},
          {"touching_columns", s.touching_columns},
          {"moved_components", s.moved_components}};
}

void add_work(std::map<std::string, double>& counters, const VoxelAbufferStatistics& s, const AbufferWork& work) {
  counters["longest_list"] = s.longest_list;
  counters["mean_list"] = static_cast<double>(s.parity_fragments + s.exact_fragments) /
                          std::max(1.0, static_cast<double>(s.filled_columns));
  counters["searches"] = static_cast<double>(work.searches);
  counters["voxel_steps"] = static_cast<double>(work.voxel_steps);
  counters["column_steps"] = static_cast<double>(work.column_steps);
  counters["bisection_steps"] = static_cast<double>(work.bisection_steps);
  counters["triangle_tests"] = static_cast<double>(work.triangle_tests);
  counters["ambiguous_starts"] = static_cast<double>(work.ambiguous_starts);
  counters["facing_misses"] = static_cast<double>(work.facing_misses);
}

std::map<std::string, double> counters_of(const ComparedStatistics& s) {
  return {{"builds", static_cast<double>(s.builds)},
          {"build_seconds", s.build_seconds},
          {"structure_bytes", static_cast<double>(s.bytes)},
          {"occupied_voxels", s.occupied_voxels}};
}

}  // namespace

VoxelAbufferOptions abuffer_options(const AbufferParameters& parameters) {
  VoxelAbufferOptions options;
  options.abuffer_size = pixels_of(parameters);
  options.grid_size = voxels_of(parameters);
  options.intersect = parameters.intersect;
  options.search = parameters.search;
  options.axis_rule = parameters.axis_rule;
  options.bisections = static_cast<uint32_t>(parameters.bisect);
  options.offset = parameters.offset_h;
  options.attributes = parameters.attributes;
  options.conservative_voxels = parameters.conservative_voxels;
  options.list = parameters.list;
  options.count_work = parameters.count_work;
  return options;
}

template <class T>
T& SceneStructure::own(std::unique_ptr<T> structure) {
  T& kept = *structure;
  generation_ = [&kept] { return kept.generation(); };
  intersector_ = std::move(structure);
  return kept;
}

SceneStructure::SceneStructure(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                               const AbufferParameters& parameters) {
  const auto compare = [this](auto structure) {
    auto& kept = own(std::move(structure));
    update_ = [&kept](const Scene&, const SceneChange& change) { kept.update(change); };
    rebuild_ = [&kept] { kept.rebuild(); };
    counters_ = [&kept] { return counters_of(kept.statistics()); };
  };
  const uint32_t pixels = pixels_of(parameters), voxels = voxels_of(parameters);
  switch (parameters.structure) {
    case Structure::abuffer: {
      const bool works = parameters.count_work;
      const auto keep = [this, works](auto structure) {
        auto& kept = own(std::move(structure));
        update_ = [&kept](const Scene& of, const SceneChange& change) { kept.update(of, change); };
        rebuild_ = [&kept] { kept.rebuild(); };
        counters_ = [&kept, works] {
          std::map<std::string, double> all = counters_of(kept.statistics());
          if (works) add_work(all, kept.statistics(), kept.work());
          return all;
        };
      };
      if (parameters.static_set)
        keep(std::make_unique<MovingSet>(scheduler, scene, buffers, abuffer_options(parameters)));
      else
        keep(std::make_unique<VoxelAbuffer>(scheduler, scene, buffers, abuffer_options(parameters)));
      if (const auto* const whole = dynamic_cast<const VoxelAbuffer*>(intersector_.get()))
        inspect_ = [whole](const SeenPoint& p) { return describe_voxel(*whole, p.triangle, p.position); };
      break;
    }
    case Structure::voxel: compare(std::make_unique<VoxelBits>(scheduler, buffers, pixels)); break;
    case Structure::grid: compare(std::make_unique<TriangleGrid>(scheduler, buffers, pixels, voxels)); break;
    case Structure::octree: compare(std::make_unique<SparseOctree>(scheduler, buffers, pixels)); break;
    case Structure::bvh: {
      auto& kept = own(std::make_unique<Bvh>(scheduler.device(), scene, buffers));
      update_ = [&kept, &buffers](const Scene& of, const SceneChange& change) { kept.update(of, buffers, change); };
      rebuild_ = [&kept, &scene, &buffers] {
        SceneChange everything;
        everything.topology = true;
        kept.update(scene, buffers, everything);
      };
      counters_ = [&kept] {
        return std::map<std::string, double>{{"build_seconds", kept.statistics().build_seconds},
                                             {"structure_bytes", static_cast<double>(kept.statistics().bytes)}};
      };
      break;
    }
  }
  fastest_build_ = counters_().at("build_seconds");
}

void SceneStructure::rebuild() {
  rebuild_();
  fastest_build_ = std::min(fastest_build_, counters_().at("build_seconds"));
}

std::map<std::string, double> SceneStructure::counters() const {
  std::map<std::string, double> all = counters_();
  all["fastest_build_seconds"] = fastest_build_;
  return all;
}

bool SceneStructure::wants_ends(const AbufferParameters& parameters) {
  switch (parameters.structure) {
    case Structure::abuffer: return parameters.intersect != Intersect::exact;
    case Structure::voxel:
    case Structure::octree: return true;
    default: return false;
  }
}

size_t SceneStructure::estimate_bytes(const Scene& scene, const AbufferParameters& parameters) {
  const uint32_t pixels = pixels_of(parameters);
  switch (parameters.structure) {
    case Structure::abuffer: {
      const VoxelAbufferOptions options = abuffer_options(parameters);
      if (!parameters.static_set) return estimate_abuffer_bytes(scene, options);
      return estimate_abuffer_bytes(scene, options, resting_instances(scene)) +
             estimate_abuffer_bytes(scene, options, MovingSet::moving_subset(scene, options));
    }
    case Structure::grid: return estimate_compared_bytes(scene, choose_grid_size(pixels, voxels_of(parameters)), true);
    case Structure::bvh: return Bvh::estimate_bytes(scene);
    default: return estimate_compared_bytes(scene, choose_grid_size(pixels, pixels), false);
  }
}

}  // namespace lucarium::abuffer
