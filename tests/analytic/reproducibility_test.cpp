// SPDX-License-Identifier: Apache-2.0
// Same seed, same bits; nothing half done stays; nothing that is no number passes.
#include <cstdlib>
#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::vector<float> image_of(const PathIntegrator& integrator, uint32_t side) {
  Film film(side, side);
  integrator.resolve(film);
  std::vector<float> all = film.image();
  for (const FilmLayer& layer : film.layers()) all.insert(all.end(), layer.pixels.begin(), layer.pixels.end());
  return all;
}

PathIntegratorOptions small_options(uint32_t replicates, uint32_t batch_paths) {
  PathIntegratorOptions options;
  options.replicates = replicates;
  options.samples_per_iteration = 4;
  options.batch_paths = batch_paths;
  return options;
}

constexpr uint32_t kSide = 32;

}  // namespace

TEST_CASE("reproducibility: the same seed gives the same bits, another seed others, whatever the batches") {
  const Scene scene = make_builtin_scene("cornell");
  // Whole samples, single samples, whole bands of rows, and ranges of pixels that cut rows; the last range is smaller.
  std::vector<std::vector<float>> images;
  for (const uint32_t batch_paths : {1u << 20, 1024u, 400u, 100u}) {
    TestRender render(scene, scene.cameras[0], small_options(2, batch_paths), kSide, 5);
    for (int i = 0; i < 2; ++i) REQUIRE(render.integrator->iterate());
    images.push_back(image_of(*render.integrator, kSide));
    CHECK(render.integrator->samples() == 8);
    render.integrator->reset(5);
    for (int i = 0; i < 2; ++i) REQUIRE(render.integrator->iterate());
    CHECK(images.back() == image_of(*render.integrator, kSide));
    render.integrator->reset(6);
    for (int i = 0; i < 2; ++i) REQUIRE(render.integrator->iterate());
    CHECK(images.back() != image_of(*render.integrator, kSide));
  }
  CHECK(images[0] == images[1]);
  CHECK(images[0] == images[2]);
  CHECK(images[0] == images[3]);
}

// Run by the next test in processes of their own, since drivers choose their threads once per process.
TEST_CASE("reproducibility: write an image" * doctest::skip()) {
  const char* file = std::getenv("LUCARIUM_TEST_IMAGE");
  REQUIRE(file);
  DeviceOptions device;
  device.threads = std::atoi(std::getenv("LUCARIUM_TEST_THREADS"));
  prepare_opencl_environment(device);
  const Scene scene = make_builtin_scene("cornell");
  TestRender render(scene, scene.cameras[0], small_options(2, 1u << 20), kSide, 3);
  REQUIRE(render.integrator->iterate());
  const std::vector<float> image = image_of(*render.integrator, kSide);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(image.data()), image.size() * sizeof(float));
}

TEST_CASE("reproducibility: one thread and two give the same bits") {
  const TemporaryFolder folder;
  std::vector<std::string> images;
  for (const std::string threads : {"1", "2"}) {
    const std::string file = (folder.path() / threads).string();
    const ProgramResult result = run_program("LUCARIUM_TEST_THREADS=" + threads + " LUCARIUM_TEST_IMAGE=" + file + " " +
                                             std::filesystem::read_symlink("/proc/self/exe").string() +
                                             " --no-skip -tc=\"reproducibility: write an image\"");
    INFO(result.out, result.err);
    REQUIRE(result.exit_code == 0);
    std::ifstream in(file, std::ios::binary);
    images.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  CHECK(images[0].size() > kSide * kSide * 3 * sizeof(float));
  CHECK(images[0] == images[1]);
}

TEST_CASE("reproducibility: a cancelled iteration leaves no trace") {
  const Scene scene = make_builtin_scene("cornell");
  for (const uint32_t replicates : {1u, 3u}) {
    TestRender whole(scene, scene.cameras[0], small_options(replicates, 1024), kSide);
    TestRender broken(scene, scene.cameras[0], small_options(replicates, 1024), kSide);
    REQUIRE(whole.integrator->iterate());
    REQUIRE(broken.integrator->iterate());
    const std::vector<float> before = image_of(*broken.integrator, kSide);
    const auto counters_before = broken.integrator->counters();
    for (const int passes : {0, 5, 60, 300}) {
      int left = passes;
      broken.scheduler.set_cancel([&left] { return left-- <= 0; });
      CHECK_FALSE(broken.integrator->iterate());
      CHECK(image_of(*broken.integrator, kSide) == before);
      CHECK(broken.integrator->counters() == counters_before);
    }
    broken.scheduler.set_cancel([] { return false; });
    REQUIRE(broken.integrator->iterate());
    REQUIRE(whole.integrator->iterate());
    CHECK(image_of(*broken.integrator, kSide) == image_of(*whole.integrator, kSide));
    CHECK(broken.integrator->counters() == whole.integrator->counters());
  }
}

TEST_CASE("reproducibility: samples that are no finite numbers fail the run") {
  Scene scene;
  add_box(scene, {-1, -1, -1}, {1, 1, 1}, true, add_material(scene, emitter(3e38f, 0.9f)));
  PathIntegratorOptions options;
  options.samples_per_iteration = 4;
  TestRender render(scene, look_perspective({0, 0, 0}, {1, 0, 0}, 1), options, 8);
  try {
    render.integrator->iterate();
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::technique);
    CHECK(std::string(error.what()).find("NaN") != std::string::npos);
    CHECK(render.integrator->counters().at("nonfinite") > 0);
  }
}

TEST_CASE(
    "reproducibility: the layer Variance is that of the mean of the replicates, also when they differ in length") {
  const Scene scene = make_builtin_scene("cornell");
  PathIntegratorOptions options = small_options(3, 1u << 20);  // 4 samples: replicates of 2, 1 and 1
  TestRender render(scene, scene.cameras[0], options, kSide);
  REQUIRE(render.integrator->iterate());
  Film film(kSide, kSide);
  render.integrator->resolve(film);
  const std::vector<std::vector<float>> images = render.integrator->replicate_images();
  REQUIRE(images.size() == 3);
  const std::vector<float>& variance = film.find("Variance")->pixels;
  const std::vector<float> image = film.image();
  double largest = 0;
  for (size_t i = 0; i < variance.size(); ++i) {
    const double a = images[0][i], b = images[1][i], c = images[2][i], mean = (a + b + c) / 3;
    const double expected = ((a - mean) * (a - mean) + (b - mean) * (b - mean) + (c - mean) * (c - mean)) / 2 / 3;
    CHECK(variance[i] == test::relative(expected, 1e-4));
    CHECK(image[i] == test::relative((2 * a + b + c) / 4, 1e-4));
    largest = std::max(largest, expected);
  }
  CHECK(largest > 0);
}
