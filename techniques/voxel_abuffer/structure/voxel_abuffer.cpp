// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/structure/voxel_abuffer.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/compute/program/source_library.h"
#include "voxel_abuffer/base/name.h"
#include "voxel_abuffer/structure/state.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

namespace {

constexpr const char* fewer_triangles = "use a scene with fewer triangles";

/// Replaces a buffer that is too small, with some room to spare; whether it did.
template <class T>
bool make_room(Device& device, TypedBuffer<T>& buffer, const char* name, size_t count, const char* remedy) {
  if (buffer && buffer.count() >= count) return false;
  buffer = {};
  buffer = TypedBuffer<T>(device, technique_name, name, std::max<size_t>(1, count + count / 16), remedy);
  return true;
}

}  // namespace

VoxelAbuffer::State::State(KernelScheduler& on, const SceneBuffers& of, const VoxelAbufferOptions& with,
                           const SceneSubset& part)
    : scheduler(&on),
      device(&on.device()),
      buffers(&of),
      options(with),
      subset(part),
      size(choose_grid_size(with.abuffer_size, with.grid_size, with.intersect == Intersect::exact)),
      primitives(on.device()),
      prepare_program(
          make_program(on.device(), voxel_abuffer_kernels(), {"voxel_abuffer/structure/prepare_triangles"})),
      voxel_program(make_program(on.device(), voxel_abuffer_kernels(),
                                 {"voxel_abuffer/structure/mark_voxels", "voxel_abuffer/structure/choose_axes",
                                  "voxel_abuffer/structure/check_columns", "voxel_abuffer/structure/turn_cells"})),
      grid_buffer(on.device(), technique_name, "grid", 1),
      views(on.device(), technique_name, "views", 6),
      exact_sum(on.device(), technique_name, "expected exact fragments", 1),
      parity_sum(on.device(), technique_name, "expected parity fragments", 1),
      counts(on.device(), technique_name, "counts", ABUFFER_COUNTS) {
  statistics.abuffer_size = size.pixels;
  statistics.grid_size = size.voxels;
  if (options.count_work)
    work = TypedBuffer<uint32_t>(on.device(), technique_name, "work of rays",
                                 std::vector<uint32_t>(2 * ABUFFER_WORK_COUNTS, 0));
}

void VoxelAbuffer::State::classify_scene(const Scene& scene) {
  loaded_classes = classes = classify(scene, options.intersect, subset);
  component_of = TypedBuffer<uint32_t>(*device, technique_name, "components", classes.component_of, fewer_triangles);
  component_class = TypedBuffer<uint8_t>(*device, technique_name, "classes of components", classes.parity);
  statistics.parity_triangles = classes.parity_triangles;
  statistics.exact_triangles = classes.exact_triangles;
  statistics.open_components = classes.open_components;
  statistics.moved_components = 0;
  exact.reset();
  parity.reset();
  ++generation;
  marked = TypedBuffer<uint32_t>(*device, technique_name, "marked components", classes.parity.size() + 2);
  scene_generation = 0;
}

void VoxelAbuffer::State::find_bounds(const Scene& scene) {
  bounds = subset.whole() ? Bounds{buffers->info().bounds_min.xyz(), buffers->info().bounds_max.xyz()}
                          : subset.bounds(scene);
}

void VoxelAbuffer::State::prepare() {
  const auto count = buffers->info().triangle_count;
  grid = make_grid(size, bounds, count, subset.min_pixel);
  grid_buffer.upload({grid});
  std::vector<LayeredView> six;
  for (int k = 0; k < 3; ++k) six.push_back(axis_view(grid, k, ABUFFER_EXACT(k)));
  for (int k = 0; k < 3; ++k) six.push_back(axis_view(grid, k, ABUFFER_PARITY));
  views.upload(six);
  if (buffers->generation() != scene_generation || !prepare_schedule) {
    scene_generation = buffers->generation();
    const size_t room = std::max(1u, count);
    make_room(*device, triangle_classes, "classes", LayeredRaster::class_bytes(room), fewer_triangles);
    make_room(*device, planes, "planes", room, fewer_triangles);
    generation += make_room(*device, triangles, "triangles", ABUFFER_TRIANGLE_WORDS * room, fewer_triangles);
    make_room(*device, expected_exact, "exact fragments of triangles", room, fewer_triangles);
    make_room(*device, expected_parity, "parity fragments of triangles", room, fewer_triangles);
    ScheduleRecorder recorder = scheduler->record("voxel_abuffer triangles", technique_name);
    PassBuilder pass = recorder.pass("prepare_triangles", prepare_program, "abuffer_prepare_triangles");
    buffers->bind(pass);
    pass.global(room)
        .arg("abuffer_grid", grid_buffer)
        .arg("abuffer_component_of", component_of)
        .arg("abuffer_component_class", component_class)
        .arg("abuffer_classes", triangle_classes)
        .arg("abuffer_planes", planes)
        .arg("abuffer_triangles", triangles)
        .arg("abuffer_expected_exact", expected_exact)
        .arg("abuffer_expected_parity", expected_parity);
    const auto sum = Primitives::Reduction::sum_float;
    primitives.record_reduce(recorder, "expect_exact", sum, expected_exact, exact_sum, count);
    primitives.record_reduce(recorder, "expect_parity", sum, expected_parity, parity_sum, count);
    prepare_schedule = recorder.compile();
    build_schedule = {};
  }
  scheduler->run_to_end(prepare_schedule);
  scheduler->finish();
  statistics.expected_exact_fragments = static_cast<double>(exact_sum.download()[0]);
  statistics.expected_parity_fragments = static_cast<double>(parity_sum.download()[0]);
}

/// One work-item marks them for an octant, which takes processors of other kinds longer than rays gain.
bool VoxelAbuffer::State::with_reaches() const {
  return options.intersect != Intersect::plane && keeps_reaches(grid) && device->info().type == DeviceType::cpu;
}

void VoxelAbuffer::State::reserve() {
  const auto room = [](double expected) { return static_cast<size_t>(1.02 * expected) + 4096; };
  const size_t voxel_count = 64 * brick_count(grid);
  const size_t exact_room = room(statistics.expected_exact_fragments);
  const size_t parity_room = room(statistics.expected_parity_fragments);
  if (classes.exact_triangles > 0 && !exact) exact.emplace(*scheduler, *buffers, AbufferLists::Kind::exact, size);
  if (classes.parity_triangles > 0 && !parity)
    parity.emplace(*scheduler, *buffers, AbufferLists::Kind::parity, size, options.attributes == Attributes::stored);
  generation += make_room(*device, voxels, "voxels", voxel_count, coarser_grid);
  const bool reaches = parity && with_reaches();
  generation += make_room(*device, bricks, "bricks", (reaches ? 66 : 2) * brick_count(grid), coarser_grid);
  generation += make_room(*device, cells, "cells", ABUFFER_CELL_WORDS, coarser_grid);
  if (exact) exact->reserve(grid, exact_room);
  if (!parity) return;
  make_room(*device, facing, "facing", 3 * voxel_count, coarser_grid);
  parity->reserve(grid, parity_room);
}

void VoxelAbuffer::State::run_build() {
  const auto lists_generation = [&] { return (exact ? exact->generation() : 0) + (parity ? parity->generation() : 0); };
  for (;;) {
    const uint32_t dims[4] = {grid.voxels.x, grid.voxels.y, grid.voxels.z, grid.voxels.w};
    if (!build_schedule || recorded_lists != lists_generation() || !std::equal(dims, dims + 4, recorded_voxels)) {
      record_build();
      recorded_lists = lists_generation();
      std::copy(dims, dims + 4, recorded_voxels);
    }
    scheduler->run_to_end(build_schedule);
    scheduler->finish();
    const std::vector<uint32_t> found = counts.download();
    statistics.exact_fragments = found[ABUFFER_COUNT_EXACT];
    statistics.parity_fragments = found[ABUFFER_COUNT_PARITY];
    statistics.longest_list = found[ABUFFER_COUNT_LONGEST];
    statistics.filled_columns = found[ABUFFER_COUNT_FILLED];
    // Room for more than were expected: build again, drop nothing.
    const bool exact_short = exact && statistics.exact_fragments > exact->capacity();
    const bool parity_short = parity && statistics.parity_fragments > parity->capacity();
    if (exact_short) exact->reserve(grid, statistics.exact_fragments);
    if (parity_short) parity->reserve(grid, statistics.parity_fragments);
    const size_t cell_words = size_t{ABUFFER_CELL_WORDS} * found[ABUFFER_COUNT_CELLS];
    const bool cells_short = make_room(*device, cells, "cells", cell_words, coarser_grid);
    if (!exact_short && !parity_short && !cells_short) return;
    generation += cells_short;
    build_schedule = {};
  }
}

bool VoxelAbuffer::State::move_marked() {
  if (!parity || options.intersect != Intersect::automatic) return false;
  const std::vector<uint32_t> found = marked.download();
  const size_t components = classes.parity.size();
  statistics.unbalanced_columns += found[components];
  statistics.touching_columns += found[components + 1];
  bool any = false;
  for (size_t component = 0; component < components; ++component)
    if (found[component] && classes.parity[component]) {
      classes.parity[component] = 0;
      ++statistics.moved_components;
      any = true;
    }
  if (!any) return false;
  component_class.upload(classes.parity);
  classes.parity_triangles = classes.exact_triangles = 0;
  for (const uint32_t component : classes.component_of)
    if (classes.parity[component] != ABUFFER_ABSENT)
      ++(classes.parity[component] ? classes.parity_triangles : classes.exact_triangles);
  if (classes.parity_triangles == 0) parity.reset();
  build_schedule = {};
  ++generation;
  return true;
}

void VoxelAbuffer::State::build() {
  const Stopwatch watch;
  statistics.unbalanced_columns = statistics.touching_columns = 0;
  if (statistics.moved_components > 0) {  // as a new structure would begin
    classes = loaded_classes;
    component_class.upload(classes.parity);
    statistics.moved_components = 0;
    build_schedule = {};
  }
  do {
    prepare();
    reserve();
    if (exact) exact->update();
    if (parity) parity->update();
    run_build();
  } while (move_marked());
  statistics.parity_triangles = classes.parity_triangles;
  statistics.exact_triangles = classes.exact_triangles;
  statistics.bytes = triangles.bytes() + planes.bytes() + voxels.bytes() + bricks.bytes() + cells.bytes() +
                     facing.bytes() + component_of.bytes() + triangle_classes.bytes() + expected_exact.bytes() +
                     expected_parity.bytes() + (exact ? exact->bytes() : 0) + (parity ? parity->bytes() : 0);
  ++statistics.builds;
  statistics.build_seconds = watch.seconds();
}

void VoxelAbuffer::State::compile() {
  const bool alpha = (buffers->info().flags & LUCARIUM_SCENE_HAS_ALPHA) != 0;
  std::map<std::string, std::string> defines;
  if (alpha) defines["BVH_ALPHA"] = "";
  if (options.count_work) defines["ABUFFER_COUNT_WORK"] = "";
  if (exact) defines["ABUFFER_WITH_EXACT"] = "";
  if (exact && grid.voxels.w == ABUFFER_CELLS) defines["ABUFFER_CELLS_ARE_PIXELS"] = "";
  if (parity) {
    defines["ABUFFER_WITH_PARITY"] = "";
    const bool points = options.search != Search::columns && searches_points(size);
    defines["ABUFFER_STEPS"] = !points ? "0" : options.search == Search::one_step ? "1" : "3";
    if (options.intersect == Intersect::plane) defines["ABUFFER_PLANES"] = "";
    if (with_reaches()) defines["ABUFFER_REACHES"] = "";
    if (options.intersect == Intersect::parity && classes.open_components > 0) defines["ABUFFER_OPEN_MESHES"] = "";
    if (options.attributes != Attributes::triangle) defines["ABUFFER_UNREFINED"] = "";
    if (options.attributes == Attributes::stored) defines["ABUFFER_STORED"] = "";
  }
  if (search_program && defines == search_defines) return;
  ProgramSpec spec{.name = "voxel_abuffer/search", .files = {"voxel_abuffer/search/intersect.cl"}, .defines = defines};
  spec.mad_enable = false;  // the triangle test is watertight by rounding both products of an edge alike
  SourceLibrary library;
  library.add(voxel_abuffer_kernels());
  search_program = Program(*device, library, spec);
  search_defines = defines;
  search_alpha = alpha;
  ++generation;
}

VoxelAbuffer::VoxelAbuffer(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                           const VoxelAbufferOptions& options, const SceneSubset& subset)
    : state_(std::make_unique<State>(scheduler, buffers, options, subset)) {
  state_->classify_scene(scene);
  state_->find_bounds(scene);
  state_->build();
  state_->compile();
}

VoxelAbuffer::~VoxelAbuffer() = default;

void VoxelAbuffer::update(const Scene& scene, const SceneChange& change) {
  if (change.topology || state_->grid.triangles != state_->buffers->info().triangle_count)
    state_->classify_scene(scene);
  if (change.geometry()) {
    state_->find_bounds(scene);
    state_->build();
  }
  state_->compile();
}

void VoxelAbuffer::set_subset(const SceneSubset& subset) { state_->subset = subset; }

void VoxelAbuffer::rebuild() {
  state_->build();
  state_->compile();
}

bool VoxelAbuffer::wants_ends() const { return state_->options.intersect != Intersect::exact; }

uint64_t VoxelAbuffer::generation() const {
  return state_->generation + (state_->exact ? state_->exact->generation() : 0) +
         (state_->parity ? state_->parity->generation() : 0);
}

const VoxelAbufferOptions& VoxelAbuffer::options() const { return state_->options; }

const VoxelAbufferStatistics& VoxelAbuffer::statistics() const { return state_->statistics; }

AbufferWork VoxelAbuffer::work() const {
  if (!state_->work) return {};
  const std::vector<uint32_t> words = state_->work.download();
  const auto count = [&](uint32_t what) { return words[2 * what] + (uint64_t{words[2 * what + 1]} << 32); };
  return {count(ABUFFER_WORK_RAYS),       count(ABUFFER_WORK_VOXELS),    count(ABUFFER_WORK_COLUMNS),
          count(ABUFFER_WORK_BISECTIONS), count(ABUFFER_WORK_TRIANGLES), count(ABUFFER_WORK_STARTS),
          count(ABUFFER_WORK_FACINGS)};
}

}  // namespace lucarium::abuffer
