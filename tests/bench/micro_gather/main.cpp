// SPDX-License-Identifier: Apache-2.0
// Node visits, splats and micro-samples per second of the gather kernel, on one thread, in processor time.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>

#include "gather/synthetic_forest.h"

using namespace lucarium;
using test::dvec3;

namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

uint32_t morton_code(const dvec3& p) {
  uint32_t code = 0;
  for (int bit = 0; bit < 10; ++bit)
    for (int axis = 0; axis < 3; ++axis)
      code |= (static_cast<uint32_t>((p[axis] + 1) * 511.99) >> bit & 1u) << (3 * bit + axis);
  return code;
}

constexpr double kSphereRadius = 0.4;

/// A closed room of 2 m with a sphere in its middle.
test::SyntheticForest make_room(int points_log2) {
  const int count = 1 << points_log2;
  const double sphere_area = 4 * std::numbers::pi * kSphereRadius * kSphereRadius, area = 24 + sphere_area;
  const int on_sphere = static_cast<int>(count * sphere_area / area);
  auto points = test::cube_inside(count - on_sphere, 1, [](const dvec3& p) { return dvec3(1 + p.z); });
  for (auto& p : test::sphere_inside(on_sphere, kSphereRadius, [](const dvec3&) { return dvec3(0.5); })) {
    p.normal = -p.normal;
    points.push_back(p);
  }
  test::SyntheticForest forest;
  forest.add(points, area);
  return forest;
}

/// Gathers on the walls.
std::vector<test::GatherPoint> make_gathers(int count, uint32_t edge, double alpha, bool morton) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.99, 0.99);
  std::vector<test::GatherPoint> points(static_cast<size_t>(count));
  for (auto& p : points) {
    const int axis = static_cast<int>(random() % 3), side = random() % 2 ? 1 : -1;
    p.position = dvec3(uniform(random), uniform(random), uniform(random));
    p.normal = dvec3(0);
    p.position[axis] = side;
    p.normal[axis] = -side;
    p.view = glm::normalize(dvec3(0.3, 0.2, 0.1) - p.position);
    p.alpha = alpha;
    p.diffuse_edge = alpha > 0 ? 0 : edge;
    p.specular_edge = alpha > 0 ? edge : 0;
  }
  if (morton)
    std::sort(points.begin(), points.end(),
              [](const auto& a, const auto& b) { return morton_code(a.position) < morton_code(b.position); });
  return points;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Speed of micro_rendering's gather kernel, one thread, processor time.");
  std::vector<int> points_log2 = {16};
  std::vector<uint32_t> edges = {24};
  std::vector<std::string> defines;
  int gathers = 4096, rounds = 3;
  double kappa = 1, alpha = 0;
  bool shuffled = false;
  app.add_option("--points", points_log2, "Binary logarithms of the numbers of leaves");
  app.add_option("--size", edges, "Edges of the micro-buffer");
  app.add_option("--gathers", gathers, "Gathers per run");
  app.add_option("--rounds", rounds, "Runs; the fastest counts");
  app.add_option("--kappa", kappa, "Threshold of the cut");
  app.add_option("--alpha", alpha, "GGX lobe of this width; 0: Lambert");
  app.add_flag("--shuffled", shuffled, "Gathers in random instead of Morton order");
  app.add_option("--define", defines, "NAME=VALUE of the program");
  CLI11_PARSE(app, argc, argv);
  DeviceOptions options;
  options.threads = 1;
  prepare_opencl_environment(options);
  std::map<std::string, std::string> all_defines;
  for (const std::string& define : defines)
    all_defines[define.substr(0, define.find('='))] = define.substr(define.find('=') + 1);
  std::printf("points size  visits splats listed | Mvisits/s Msplats/s Msamples/s us/gather\n");
  for (const int log2 : points_log2) {
    const test::SyntheticForest forest = make_room(log2);
    const auto buffers = forest.upload();
    for (const uint32_t edge : edges) {
      auto program_defines = all_defines;
      program_defines["MICRO_SIZE"] = std::to_string(edge);
      const Program& program = test::gather_program(program_defines);
      const auto points = make_gathers(gathers, edge, alpha, !shuffled);
      test::GatherRun run(forest, buffers, points, program);
      MicroSettings settings = test::default_settings();
      settings.kappa = static_cast<float>(kappa);
      run.run(settings);
      double seconds = 1e30;
      for (int round = 0; round < rounds; ++round) {
        const double start = processor_seconds();
        run.run(settings);
        seconds = std::min(seconds, processor_seconds() - start);
      }
      const auto total = run.result().total();
      const double n = gathers;
      std::printf("2^%-4d %4u %7.0f %6.0f %6.1f | %9.1f %9.1f %10.2f %9.1f\n", log2, edge, total.visits / n,
                  total.splats / n, total.listed / n, total.visits / seconds * 1e-6, total.splats / seconds * 1e-6,
                  n * edge * edge / seconds * 1e-6, seconds / n * 1e6);
    }
  }
}
