// SPDX-License-Identifier: Apache-2.0
#include "structure.h"

#include <fmt/format.h>

#include "voxel_abuffer/compared/sparse_octree.h"
#include "voxel_abuffer/compared/triangle_grid.h"
#include "voxel_abuffer/compared/voxel_bits.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::bench {

namespace {

Structure wrap(std::unique_ptr<abuffer::ComparedStructure> made) {
  abuffer::ComparedStructure* structure = made.get();
  const auto summary = [structure] {
    const abuffer::ComparedStatistics& s = structure->statistics();
    return fmt::format("{} voxels along the longest side, {} occupied, {} pairs, {} bytes, {} more to build", s.voxels,
                       s.occupied_voxels, s.pairs, s.bytes, s.build_bytes);
  };
  return {std::move(made), [structure] { structure->rebuild(); }, summary};
}

Structure wrap(std::unique_ptr<abuffer::VoxelAbuffer> made) {
  abuffer::VoxelAbuffer* structure = made.get();
  const auto summary = [structure] {
    const abuffer::VoxelAbufferStatistics& s = structure->statistics();
    return fmt::format("n={}, N={}, {} exact and {} parity fragments, {} bytes", s.abuffer_size, s.grid_size,
                       s.exact_fragments, s.parity_fragments, s.bytes);
  };
  return {std::move(made), [structure] { structure->rebuild(); }, summary};
}

abuffer::VoxelAbufferOptions options_of(const std::string& mode, uint32_t size, uint32_t grid) {
  abuffer::VoxelAbufferOptions o{.abuffer_size = size, .grid_size = grid};
  using abuffer::Intersect;
  o.intersect = mode == "exact" ? Intersect::exact : mode == "auto" ? Intersect::automatic : Intersect::parity;
  if (mode == "linked") o.list = LayeredVariant::linked_list;
  if (mode == "3" || mode == "1") o.search = mode == "3" ? abuffer::Search::three_steps : abuffer::Search::one_step;
  return o;
}

}  // namespace

Structure make_structure(const std::string& named, KernelScheduler& scheduler, const Scene& scene,
                         const SceneBuffers& buffers, uint32_t size, uint32_t grid) {
  const size_t at = named.find('@');
  const std::string mode = named.substr(0, at);
  if (at != std::string::npos) grid = static_cast<uint32_t>(std::stoul(named.substr(at + 1)));
  if (mode == "grid") return wrap(std::make_unique<abuffer::TriangleGrid>(scheduler, buffers, size, grid));
  if (mode == "octree") return wrap(std::make_unique<abuffer::SparseOctree>(scheduler, buffers, size));
  if (mode == "voxel") return wrap(std::make_unique<abuffer::VoxelBits>(scheduler, buffers, size));
  return wrap(std::make_unique<abuffer::VoxelAbuffer>(scheduler, scene, buffers, options_of(mode, size, grid)));
}

}  // namespace lucarium::bench
