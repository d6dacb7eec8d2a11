// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/light/leaf_light.h"

#include <algorithm>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/seed.h"
#include "lucarium/compute/program/program.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr double kLeavesPerGather = 1024;  // of which a shadow ray each takes about as long as one gather
const char* const kFewerPoints = "lower points_log2";
// Apart from the gathers at pixels, which get the seed itself.
constexpr uint32_t kNodeSeed = 0x6a61636fu;

Program light_program(Device& device, const MicroParameters& parameters) {
  std::vector<std::string> files = {"micro_rendering/light/pull_radiance"};
  if (parameters.node_shading == NodeShading::dynamic) files.emplace_back("micro_rendering/light/choose_leaves");
  return make_program(device, micro_rendering_kernels(), std::move(files));
}

}  // namespace

LeafLight::LeafLight(Device& device, KernelScheduler& scheduler, const Scene& host_scene, const SceneBuffers& scene,
                     const Intersector& intersector, const PointForest& forest, const GatherPass& gather,
                     const MicroParameters& parameters, int bounces, const std::string& owner)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      intersector_(intersector),
      forest_(forest),
      parameters_(parameters),
      bounces_(bounces),
      owner_(owner),
      program_(light_program(device, parameters)),
      primitives_(device) {
  const uint32_t leaves = forest.leaf_count();
  direct_ = TypedBuffer<float4>(device, owner, "direct light at leaves", leaves, kFewerPoints);
  if (dynamic()) {
    shading_ = DynamicShading(device, owner, leaves);
    arriving_ = TypedBuffer<MicroLeafLight>(device, owner, "arriving light samples of leaves", leaves, kFewerPoints);
    record_lobes();
  }
  if (parameters.multibounce != MultiBounce::jacobi) {
    paths_ = std::make_unique<PathLight>(device, scheduler, host_scene, scene, intersector, forest, parameters, bounces,
                                         direct_, arriving_, owner);
  } else if (bounces > 1) {
    irradiance_ = TypedBuffer<float4>(device, owner, "light at leaves", leaves, kFewerPoints);
    nodes_ = std::make_unique<NodeGather>(device, scheduler, scene, forest, gather, shading_, parameters, owner);
    record_bounce();
  }
  record_direct();
  record_pull();
}

/// One light sample per leaf, added to direct_.
void LeafLight::record_direct() {
  ScheduleRecorder recorder = scheduler_.record("light at points", owner_);
  sample_ = recorder.variable("sample", 0u);
  light_seed_ = recorder.variable("seed", 0u);
  const float weight = 1.f / static_cast<float>(parameters_.light_samples);
  light_at_points(device_, scene_, intersector_, forest_, {}, parameters_, owner_)
      .record_samples(recorder, sample_, light_seed_, bind_light_sums(parameters_, weight, direct_, arriving_));
  direct_schedule_ = recorder.compile();
}

/// From the leaves' irradiance to the radiance of all nodes.
void LeafLight::add_pull(ScheduleRecorder& recorder, const BufferRef& irradiance, bool choose) {
  const uint32_t leaves = forest_.leaf_count();
  const BufferRef brightness = recorder.transient<float>("brightness of leaves", leaves, kFewerPoints);
  const BufferRef brightest = recorder.transient<float>("brightest leaf", 1);
  const BufferRef extremes = recorder.transient<float4>("extremes of nodes", size_t{2} * leaves, kFewerPoints);
  recorder.pass("brightness of leaves", program_, "find_leaf_brightness")
      .global(leaves)
      .arg("irradiance", irradiance)
      .arg("leaf_albedo", forest_.leaf_albedo)
      .arg("count", leaves)
      .arg("brightness", brightness);
  primitives_.record_reduce(recorder, "brightest leaf", Primitives::Reduction::max_float, brightness, brightest,
                            leaves);
  recorder.pass("unit of radiance", program_, "store_radiance_unit")
      .global(1)
      .arg("brightest", brightest)
      .arg("radiance_unit", forest_.radiance_unit);
  for (uint32_t t = 0; t < forest_.trees().size(); ++t) {
    const ForestTree& tree = forest_.trees()[t];
    recorder.pass("store radiance", program_, "store_radiance")
        .global(tree.leaves())
        .arg("irradiance", irradiance)
        .arg("leaf_albedo", forest_.leaf_albedo)
        .arg("radiance_unit", forest_.radiance_unit)
        .arg("trees", forest_.tree_records)
        .arg("tree", t)
        .arg("nodes", forest_.nodes)
        .arg("count", tree.leaves())
        .arg("radiance", forest_.radiance)
        .arg("extremes", extremes);
    forest_.add_level_passes(recorder, "pull", program_, "pull_radiance", t, [&](PassBuilder& pass) {
      pass.arg("radiance", forest_.radiance).arg("extremes", extremes);
    });
  }
  if (choose) add_choices(recorder, extremes);
}

/// What has arrived at leaves, and the leaf that every node stands for where glossy lobes are asked for.
void LeafLight::add_choices(ScheduleRecorder& recorder, const BufferRef& extremes) {
  choice_seed_ = recorder.variable("seed", 0u);
  for (uint32_t t = 0; t < forest_.trees().size(); ++t) {
    const ForestTree& tree = forest_.trees()[t];
    recorder.pass("choose leaves", program_, "choose_leaves")
        .global(tree.leaves())
        .arg("arriving", arriving_)
        .arg("trees", forest_.tree_records)
        .arg("tree", t)
        .arg("count", tree.leaves())
        .arg("leaf_lights", shading_.leaf_lights)
        .arg("choices", shading_.choices);
    forest_.add_level_passes(recorder, "pull choices", program_, "pull_choices", t, [&](PassBuilder& pass) {
      pass.arg("seed", choice_seed_).arg("extremes", extremes).arg("choices", shading_.choices);
    });
  }
}

/// Depends on geometry and materials alone.
void LeafLight::record_lobes() {
  const uint32_t leaves = forest_.leaf_count();
  ScheduleRecorder recorder = scheduler_.record("lobes of leaves", owner_);
  PassBuilder pass = recorder.pass("lobes of leaves", program_, "store_leaf_lobes");
  scene_.bind(pass);
  pass.global(leaves).arg("leaves", forest_.leaves).arg("count", leaves).arg("leaf_lobes", shading_.leaf_lobes);
  lobes_schedule_ = recorder.compile();
}

void LeafLight::record_pull() {
  ScheduleRecorder recorder = scheduler_.record("pull", owner_);
  add_pull(recorder, direct_, dynamic());
  pull_schedule_ = recorder.compile();
}

/// What nodes have gathered: pushed to the leaves, and pulled.
void LeafLight::record_bounce() {
  ScheduleRecorder recorder = scheduler_.record("bounce", owner_);
  nodes_->add_push(recorder, direct_, irradiance_);
  add_pull(recorder, irradiance_, false);
  bounce_schedule_ = recorder.compile();
}

void LeafLight::changed(bool surfaces) {
  stage_ = Stage::none;
  shines_ = false;
  if (!surfaces) return;
  lobes_known_ = false;
  if (nodes_) nodes_->geometry_changed();
}

void LeafLight::begin(uint32_t frame, uint32_t seed) {
  scheduler_.finish();
  direct_.fill_zero();
  if (dynamic()) arriving_.fill_zero();
  frame_ = frame;
  seed_ = seed;
  part_ = 0;
  const bool sampled = parameters_.multibounce != MultiBounce::photon_map || !parameters_.photon_direct;
  stage_ = sampled ? Stage::samples : Stage::paths;
}

bool LeafLight::step(uint32_t frame, uint32_t seed) {
  if (stage_ == Stage::none || frame_ != frame || seed_ != seed) begin(frame, seed);
  last_work_ = 0;
  return advance();
}

bool LeafLight::receive(uint32_t frame, uint32_t seed) {
  do {
    if (!step(frame, seed)) return false;
  } while (stage_ < Stage::pull);
  return true;
}

bool LeafLight::spread() {
  while (stage_ != Stage::done)
    if (!step(frame_, seed_)) return false;
  return true;
}

bool LeafLight::advance() {
  switch (stage_) {
    case Stage::samples: return sample();
    case Stage::paths:
      if (paths_ && !paths_->trace(frame_, seed_)) return false;
      last_work_ = paths_ ? paths_->traced_rays() / kLeavesPerGather : 0;
      part_ = 0;
      stage_ = paths_ && paths_->parts() > 0 ? Stage::path_light : Stage::pull;
      return true;
    case Stage::path_light: return add_path_light();
    case Stage::pull: return pull();
    case Stage::gather: return gather();
    case Stage::none:
    case Stage::done: break;
  }
  return true;
}

/// Its last pass alone adds something: one that was cancelled has added nothing.
bool LeafLight::sample() {
  direct_schedule_.set(light_seed_, seed_);
  direct_schedule_.set(sample_, frame_ * static_cast<uint32_t>(parameters_.light_samples) + part_);
  if (scheduler_.run(direct_schedule_) == RunResult::cancelled) return false;
  last_work_ = forest_.leaf_count() / kLeavesPerGather;
  if (++part_ == static_cast<uint32_t>(parameters_.light_samples)) stage_ = Stage::paths;
  return true;
}

bool LeafLight::add_path_light() {
  if (!paths_->add(part_)) {
    if (!paths_->adds_whole_parts()) stage_ = Stage::none;
    return false;
  }
  last_work_ = forest_.leaf_count() / kLeavesPerGather;
  if (++part_ == paths_->parts()) stage_ = Stage::pull;
  return true;
}

/// To its end: cancelled between levels of a tree it would leave nodes in units that do not belong together.
bool LeafLight::pull() {
  if (dynamic()) {
    if (!lobes_known_) scheduler_.run_to_end(lobes_schedule_);
    lobes_known_ = true;
    pull_schedule_.set(choice_seed_, indexed_seed(seed_, frame_));
  }
  scheduler_.run_to_end(pull_schedule_);
  shines_ = true;
  if (nodes_) nodes_->list();
  part_ = 0;
  bounce_ = 1;
  stage_ = nodes_ ? Stage::gather : Stage::done;
  return true;
}

/// A batch of nodes; after the last one of a bounce all leaves and nodes shine with it.
bool LeafLight::gather() {
  const uint32_t number = frame_ * static_cast<uint32_t>(bounces_) + static_cast<uint32_t>(bounce_);
  if (!nodes_->gather(part_, indexed_seed(seed_ ^ kNodeSeed, number))) return false;
  const uint32_t made = std::min(NodeGather::kBatch, nodes_->count() - part_);
  gathers_ += made;
  last_work_ = made;
  part_ += made;
  if (part_ < nodes_->count()) return true;
  scheduler_.run_to_end(bounce_schedule_);  // as pull()
  part_ = 0;
  if (++bounce_ == bounces_) stage_ = Stage::done;
  return true;
}

void LeafLight::warm_up() {
  for (Schedule* schedule : {&direct_schedule_, &pull_schedule_, &bounce_schedule_, &lobes_schedule_})
    if (*schedule) scheduler_.warm_up(*schedule);
  if (nodes_) nodes_->warm_up();
  if (paths_) paths_->warm_up();
}

size_t LeafLight::estimate_bytes(const MicroParameters& parameters, size_t leaves, int bounces) {
  const size_t transient = LightAtPoints::estimate_bytes(leaves) + leaves * (2 * sizeof(uint32_t) + 2 * sizeof(float4));
  const size_t shading = parameters.node_shading == NodeShading::dynamic
                             ? DynamicShading::estimate_bytes(leaves) + leaves * sizeof(MicroLeafLight)
                             : 0;
  if (parameters.multibounce != MultiBounce::jacobi)
    return shading + leaves * sizeof(float4) + 2 * transient + PathLight::estimate_bytes(parameters, leaves, bounces);
  return shading + leaves * sizeof(float4) + 2 * transient +
         (bounces > 1 ? leaves * sizeof(float4) + NodeGather::estimate_bytes(parameters, leaves) : 0);
}

}  // namespace lucarium::micro
