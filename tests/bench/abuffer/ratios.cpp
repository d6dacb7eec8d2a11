// SPDX-License-Identifier: Apache-2.0
#include "ratios.h"

#include <fmt/format.h>

#include <cstdio>

#include "contest.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"
#include "voxel_abuffer/structure_bytes.h"

namespace lucarium::bench {

namespace {

using abuffer::Intersect;
using abuffer::Search;
using abuffer::VoxelAbuffer;
using abuffer::VoxelAbufferOptions;

void print_row(const std::string& what, double floor, double goal, double value, bool at_most = false) {
  const auto reached = [&](double bar) { return at_most ? value <= bar : value >= bar; };
  const char* verdict = reached(goal) ? "goal" : reached(floor) ? "floor" : "no";
  fmt::print("| {} | {}{} | {}{} | {:.3g} | {} |\n", what, at_most ? "≤ " : "", floor, at_most ? "≤ " : "", goal, value,
             verdict);
  std::fflush(stdout);
}

VoxelAbufferOptions exact() { return {.intersect = Intersect::exact}; }
VoxelAbufferOptions parity(Search search, uint32_t size = 1280, LayeredVariant list = LayeredVariant::tiles) {
  return {.abuffer_size = size, .intersect = Intersect::parity, .search = search, .list = list};
}

/// Every triangle as nine, each edge in three: the same surfaces.
Scene nine_times(const Scene& from) {
  Scene scene = from;
  for (Mesh& mesh : scene.meshes) {
    Mesh finer = mesh;
    finer.positions.clear();
    finer.normals.clear();
    finer.triangles.clear();
    finer.tangents.clear();
    finer.uv[0].clear();
    finer.uv[1].clear();
    finer.colors.clear();
    finer.morph_targets.clear();
    for (const glm::uvec3& t : mesh.triangles) {
      const auto first = static_cast<uint32_t>(finer.positions.size());
      const auto mix = [&](const std::vector<glm::vec3>& v, int i, int j) {
        return (static_cast<float>(3 - i) * v[t.x] + static_cast<float>(i - j) * v[t.y] +
                static_cast<float>(j) * v[t.z]) /
               3.f;
      };
      for (int i = 0; i <= 3; ++i)
        for (int j = 0; j <= i; ++j) {
          finer.positions.push_back(mix(mesh.positions, i, j));
          finer.normals.push_back(mix(mesh.normals, i, j));
        }
      const auto at = [&](int i, int j) { return first + static_cast<uint32_t>(i * (i + 1) / 2 + j); };
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
          finer.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
          if (j < i) finer.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    mesh = std::move(finer);
  }
  for (auto& node : scene.nodes) node.morph_weights.clear();
  for (SceneInstance& instance : scene.instances) instance.pose.reset();
  scene.animations.clear();
  return posed(std::move(scene), 0, none);
}

class Ratios {
 public:
  Ratios(KernelScheduler& scheduler, int rounds, uint32_t width, uint32_t height)
      : scheduler_(scheduler), rounds_(rounds), width_(width), height_(height) {}

  void run() {
    fmt::print("| ratio | floor | goal | value | reached |\n|---|---|---|---|---|\n");
    rays("builtin:atrium", "atrium");
    rays("builtin:solids", "solids");
    grid_and_octree();
    builds();
    debris();
    resolution();
    stated_bytes();
  }

 private:
  Contest contest() { return {scheduler_.device(), scheduler_, rounds_}; }
  RaySubject subject(const std::string& name) {
    return {scheduler_.device(), scheduler_, name, width_, height_, false};
  }

  void rays(const std::string& name, const std::string& place) {
    const RaySubject rays = subject(name);
    Stage stage(scheduler_, load_scene(name));
    VoxelAbuffer three(scheduler_, stage.scene, stage.buffers, parity(Search::three_steps));
    VoxelAbuffer columns(scheduler_, stage.scene, stage.buffers, parity(Search::columns));
    VoxelAbuffer exactly(scheduler_, stage.scene, stage.buffers, exact());
    for (const RayKind kind : {RayKind::diffuse, RayKind::shadow}) {
      Contest all = contest();
      all.add_rays("wide", stage.bvh, rays, kind);
      all.add_rays("3", three, rays, kind);
      all.add_rays("2d", columns, rays, kind);
      all.add_rays("exact", exactly, rays, kind);
      all.run();
      const bool shadow = kind == RayKind::shadow;
      const std::string what = fmt::format("{}, {} rays per second over `wide`: ", place, shadow ? "shadow" : "bounce");
      print_row(what + "three steps", shadow ? .15 : .2, shadow ? .4 : .5, all.ratio(0, 1));
      if (!shadow) print_row(what + "2D-DDA", .15, .35, all.ratio(0, 2));
      print_row(what + "exact", shadow ? .1 : .12, shadow ? .25 : .3, all.ratio(0, 3));
    }
    Contest threads = contest();
    threads.add_rays("one", exactly, rays, RayKind::diffuse, 1);
    threads.add_rays("two", exactly, rays, RayKind::diffuse, 2);
    threads.run();
    print_row(place + ", bounce rays, two threads over one (elapsed, fastest)", 1.6, 1.9,
              threads.fastest(0) / threads.fastest(1));
  }

  void grid_and_octree() {
    const RaySubject rays = subject("builtin:atrium");
    Stage stage(scheduler_, load_scene("builtin:atrium"));
    VoxelAbuffer exactly(scheduler_, stage.scene, stage.buffers, exact());
    Contest grids = contest();
    grids.add_rays("exact", exactly, rays, RayKind::diffuse);
    std::vector<Structure> kept;
    for (const uint32_t voxels : {64u, 128u, 192u}) {
      kept.push_back(make_structure("grid", scheduler_, stage.scene, stage.buffers, 1280, voxels));
      grids.add_rays("grid", *kept.back().intersector, rays, RayKind::diffuse);
    }
    grids.run();
    print_row("atrium, bounce rays per second, exact over `grid` with the best of 64, 128, 192 voxels", .8, 1.3,
              std::min({grids.ratio(1, 0), grids.ratio(2, 0), grids.ratio(3, 0)}));
    const RaySubject bounces = subject("builtin:solids");
    Stage solids(scheduler_, load_scene("builtin:solids"));
    VoxelAbuffer three(scheduler_, solids.scene, solids.buffers, parity(Search::three_steps, 1024));
    const Structure octree = make_structure("octree", scheduler_, solids.scene, solids.buffers, 1024, 0);
    Contest trees = contest();
    trees.add_rays("ours", three, bounces, RayKind::diffuse);
    trees.add_rays("octree", *octree.intersector, bounces, RayKind::diffuse);
    trees.add("build", [&] { three.rebuild(); });
    trees.add("build octree", octree.rebuild);
    trees.run();
    print_row("solids, 1024 pixels: build, octree over three steps", 1.5, 3.2, trees.ratio(3, 2));
    print_row("solids, 1024 pixels: bounce rays, octree over three steps", 2, 7.3, trees.ratio(1, 0));
  }

  double build_over_ours(Scene scene, double& ours) {
    Stage stage(scheduler_, std::move(scene));
    VoxelAbuffer exactly(scheduler_, stage.scene, stage.buffers, exact());
    Contest all = contest();
    all.add("wide", [&] { stage.bvh.update(stage.scene, stage.buffers, everything()); });
    all.add("exact", [&] { exactly.rebuild(); });
    all.run();
    ours = all.seconds(1);
    return all.ratio(0, 1);
  }

  void builds() {
    double solids = 0, finer = 0, unused = 0;
    print_row("atrium, 314 000 triangles: build, `Bvh` over exact", 1, 2.5,
              build_over_ours(load_scene("builtin:atrium"), unused));
    print_row("debris, 980 000 triangles: build, `Bvh` over exact", 2, 5,
              build_over_ours(load_scene("builtin:debris:pieces=20000"), unused));
    const Scene scene = load_scene("builtin:solids");
    build_over_ours(scene, solids);
    build_over_ours(nine_times(scene), finer);
    print_row("solids: exact build, nine times the triangles on the same surfaces over once", 4, 2.5, finer / solids,
              true);
    Stage stage(scheduler_, scene);
    VoxelAbuffer tiles(scheduler_, stage.scene, stage.buffers, parity(Search::columns));
    VoxelAbuffer linked(scheduler_, stage.scene, stage.buffers,
                        parity(Search::columns, 1280, LayeredVariant::linked_list));
    Contest lists = contest();
    lists.add("tiles", [&] { tiles.rebuild(); });
    lists.add("linked", [&] { linked.rebuild(); });
    lists.run();
    print_row("solids: build for parity, linked lists over tiles", 1.8, 2.5, lists.ratio(1, 0));
    VoxelAbuffer exactly(scheduler_, stage.scene, stage.buffers, exact());
    Contest threads = contest();
    threads.add(
        "one", [&] { exactly.rebuild(); }, 1);
    threads.add(
        "two", [&] { exactly.rebuild(); }, 2);
    threads.run();
    print_row("solids: exact build, two threads over one (elapsed, fastest)", 1.6, 1.9,
              threads.fastest(0) / threads.fastest(1));
  }

  /// Rays per frame R up to which B + R c of ours is less than that of the hierarchy rebuilt.
  void debris() {
    const RaySubject rays = subject("builtin:debris");
    Stage stage(scheduler_, load_scene("builtin:debris"));
    VoxelAbuffer exactly(scheduler_, stage.scene, stage.buffers, exact());
    Contest all = contest();
    all.add("wide", [&] { stage.bvh.update(stage.scene, stage.buffers, everything()); });
    all.add("exact", [&] { exactly.rebuild(); });
    all.add_rays("wide", stage.bvh, rays, RayKind::diffuse);
    all.add_rays("exact", exactly, rays, RayKind::diffuse);
    all.run();
    const double per_ray = (all.seconds(3) - all.seconds(2)) / static_cast<double>(rays.diffuse.size());
    const double pays = std::max(0.0, (all.seconds(0) - all.seconds(1)) / per_ray);
    print_row("debris, 200 000 triangles: million rays per frame up to which exact beats `Bvh` rebuilt", .1, .5,
              1e-6 * pays);
  }

  void resolution() {
    const RaySubject rays = subject("builtin:solids");
    Stage stage(scheduler_, load_scene("builtin:solids"));
    VoxelAbuffer coarse(scheduler_, stage.scene, stage.buffers, parity(Search::three_steps, 640));
    VoxelAbuffer fine(scheduler_, stage.scene, stage.buffers, parity(Search::three_steps, 2560));
    Contest all = contest();
    all.add_rays("640", coarse, rays, RayKind::diffuse);
    all.add_rays("2560", fine, rays, RayKind::diffuse);
    all.run();
    print_row("solids, three steps: time of bounce rays, 2560 pixels over 640", 1.3, 1, all.ratio(1, 0), true);
  }

  void stated_bytes() {
    for (const char* name : {"builtin:atrium", "builtin:debris"}) {
      const Scene scene = load_scene(name);
      const SceneBuffers buffers(scheduler_.device(), scene);
      const MemoryAccount& memory = scheduler_.device().memory();
      const auto held = [&] {
        const auto owners = memory.by_owner();
        const auto found = owners.find("voxel_abuffer");
        return found == owners.end() ? size_t{0} : found->second;
      };
      const size_t before = held();
      VoxelAbuffer structure(scheduler_, scene, buffers, exact());
      const size_t taken = held() - before;
      print_row(fmt::format("{}: bytes taken over bytes stated before", name), 1, .9,
                static_cast<double>(taken) / static_cast<double>(abuffer::estimate_abuffer_bytes(scene, exact())),
                true);
      SceneChange camera;
      camera.camera = true;
      const uint64_t builds = structure.statistics().builds;
      structure.update(scene, camera);
      print_row(fmt::format("{}: builds after a move of the camera", name), 0, 0,
                static_cast<double>(structure.statistics().builds - builds), true);
    }
  }

  KernelScheduler& scheduler_;
  int rounds_;
  uint32_t width_, height_;
};

}  // namespace

void measure_ratios(KernelScheduler& scheduler, int rounds, uint32_t width, uint32_t height) {
  Ratios(scheduler, rounds, width, height).run();
}

}  // namespace lucarium::bench
