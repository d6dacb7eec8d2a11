// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/light/node_gather.h"

#include <algorithm>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/compute/program/program.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr uint32_t kMinLevels = 6;   // of a small tree's level that gathers
constexpr uint32_t kMaxOfLevel = 2;  // times as many nodes as the level alone has
const char* const kLowerLevel = "lower jacobi_level";

Program nodes_program(Device& device) {
  return make_program(device, micro_rendering_kernels(),
                      {"micro_rendering/light/list_node_gathers", "micro_rendering/light/push_irradiance"});
}

}  // namespace

NodeGather::NodeGather(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const PointForest& forest,
                       const GatherPass& gather, const DynamicShading& shading, const MicroParameters& parameters,
                       const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      forest_(forest),
      gather_(gather),
      shading_(shading),
      parameters_(parameters),
      owner_(owner),
      program_(nodes_program(device)),
      primitives_(device) {
  for (const ForestTree& tree : forest.trees()) {
    first_root_.push_back(roots_);
    roots_ += 1u << level_of(tree);
  }
  const size_t max_nodes = size_t{kMaxOfLevel} * roots_;
  totals_ = TypedBuffer<uint32_t>(device, owner, "sizes of cuts", MICRO_CUT_LEVELS + 1);
  cut_results_ = TypedBuffer<uint32_t>(device, owner, "first results of cuts", roots_, kLowerLevel);
  leaf_results_ = TypedBuffer<uint32_t>(device, owner, "results of leaves", forest.leaf_count(), kLowerLevel);
  node_count_ = TypedBuffer<uint32_t>(device, owner, "number of gathers at nodes", 1);
  gathers_ = TypedBuffer<MicroGather>(device, owner, "gathers at nodes", max_nodes, kLowerLevel);
  results_ = GatherResults(device, owner, "nodes'", max_nodes, false);
  record_list();
  record_gather();
}

/// Level of the nodes that gather: about the same size of nodes in all trees, finer in small ones.
uint32_t NodeGather::level_of(const ForestTree& tree) const {
  const int depth = static_cast<int>(tree.record.depth);
  const int level = parameters_.jacobi_level - (parameters_.points_log2 - depth);
  return static_cast<uint32_t>(std::clamp(level, std::min(depth, static_cast<int>(kMinLevels)), depth));
}

void NodeGather::record_list() {
  ScheduleRecorder recorder = scheduler_.record("cut of gathering nodes", owner_);
  const float cone = parameters_.jacobi_cone * (3.14159265f / 180);
  const uint32_t max_nodes = kMaxOfLevel * roots_;
  const auto pass_of = [&](const char* name, const char* kernel, uint32_t t) {
    const uint32_t level = level_of(forest_.trees()[t]);
    PassBuilder pass = recorder.pass(name, program_, kernel);
    pass.global(size_t{1} << level)
        .local(1)
        .arg("trees", forest_.tree_records)
        .arg("tree", t)
        .arg("level", level)
        .arg("cone", cone)
        .arg("nodes", forest_.nodes)
        .arg("totals", totals_);
    return pass;
  };
  const auto trees = static_cast<uint32_t>(forest_.trees().size());
  recorder.fill_zero("sizes of cuts", totals_);
  for (uint32_t t = 0; t < trees; ++t) pass_of("sizes of cuts", "sum_cut_sizes", t);
  for (uint32_t t = 0; t < trees; ++t)
    pass_of("nodes of the cut", "count_cut_nodes", t)
        .arg("first_root", first_root_[t])
        .arg("max_nodes", max_nodes)
        .arg("cut_results", cut_results_);
  primitives_.record_exclusive_scan(recorder, "first results of cuts", cut_results_, cut_results_, node_count_, roots_);
  for (uint32_t t = 0; t < trees; ++t) {
    PassBuilder pass = pass_of("gathers at nodes", "list_cut_gathers", t);
    scene_.bind(pass);
    pass.arg("leaves", forest_.leaves)
        .arg("first_root", first_root_[t])
        .arg("max_nodes", max_nodes)
        .arg("cut_results", cut_results_)
        .arg("micro_size", static_cast<uint32_t>(parameters_.micro_size))
        .arg("triangle_edges", forest_.triangle_edges)
        .arg("gathers", gathers_)
        .arg("leaf_results", leaf_results_);
  }
  list_schedule_ = recorder.compile();
}

void NodeGather::record_gather() {
  ScheduleRecorder recorder = scheduler_.record("gather at nodes", owner_);
  settings_ = recorder.variable("settings", MicroSettings{});
  gather_.record(recorder, "gather at nodes", scene_, forest_, gathers_, node_count_,
                 std::min(kBatch, static_cast<uint32_t>(gathers_.count())), settings_, results_, shading_);
  gather_schedule_ = recorder.compile();
}

void NodeGather::list() {
  if (listed_) return;
  scheduler_.run_to_end(list_schedule_);
  scheduler_.finish();
  count_ = node_count_.download().front();
  listed_ = true;
}

bool NodeGather::gather(uint32_t first, uint32_t seed) {
  MicroSettings settings = GatherPass::settings(parameters_, seed);
  settings.kappa = parameters_.node_kappa();
  settings.first = first;
  gather_schedule_.set(settings_, settings);
  return scheduler_.run(gather_schedule_) == RunResult::done;
}

void NodeGather::add_push(ScheduleRecorder& recorder, const BufferRef& direct, const BufferRef& irradiance) const {
  const uint32_t leaves = forest_.leaf_count();
  recorder.pass("push", program_, "push_irradiance")
      .global(leaves)
      .arg("count", leaves)
      .arg("leaf_results", leaf_results_)
      .arg("direct", direct)
      .arg("gathered", results_.irradiance)
      .arg("irradiance", irradiance);
}

void NodeGather::warm_up() {
  scheduler_.warm_up(list_schedule_);
  scheduler_.warm_up(gather_schedule_);
}

size_t NodeGather::estimate_bytes(const MicroParameters& parameters, size_t leaves) {
  const size_t roots =
      size_t{2} << std::min(parameters.jacobi_level, parameters.points_log2);  // a level is clamped to its tree
  return roots * (sizeof(uint32_t) + kMaxOfLevel * sizeof(MicroGather)) + leaves * sizeof(uint32_t) +
         GatherResults::estimate_bytes(kMaxOfLevel * roots, false) + (size_t{1} << 16);
}

}  // namespace lucarium::micro
