// SPDX-License-Identifier: Apache-2.0
// The rest of a series of bounces. Transport and scattering are a linear map A; sweep s sends a_s = A a_(s-1), and what
// is missing after it is Σ_(k>=1) A^k a_s. Where a_s has become an eigenvector of the largest eigenvalue λ that is
// λ / (1 - λ) a_s; what is not yet one, a_s - λ a_(s-1), bounds the error: λ |a_s - λ a_(s-1)| / ((1 - λ)² |T|).
//
// Diffuse boxes of about 6 x 6 texels a wall, light after K sweeps against that after very many.
#include <doctest/doctest.h>

#include <cmath>

#include "lamp_box.h"
#include "tolerance.h"

using namespace lucarium;
using test::LampBox;
using test::relative;

namespace {

struct Errors {
  double with_tail, without;  ///< of irradiance: RMS error by area, over the RMS
  double sent, bound;         ///< with the tail, of what is sent: the same of albedo times irradiance; its bound
  double lambda;
};

/// After 1, 2, ... sweeps.
std::vector<Errors> errors_by_sweep(Scene scene, const std::vector<double>& albedos, int texels, uint32_t sweeps) {
  vlf::Parameters parameters;
  parameters.dir_n = 6;
  parameters.cells = 32;
  parameters.texels = texels;
  parameters.direct_mode = vlf::DirectMode::exchange;
  parameters.residual = 0;
  test::FieldRig rig(std::move(scene), parameters);
  std::vector<std::vector<double>> with_tail, without;
  std::vector<Errors> errors;
  for (uint32_t sweep = 1; sweep <= sweeps; ++sweep) {
    rig.propagate(sweep);
    const std::vector<double> all = rig.all();
    std::vector<double> longer = all;
    const std::vector<float4> last = rig.field().last().download();
    const double factor = static_cast<double>(rig.field().tail().factor.x);
    for (size_t side = 0; side < all.size(); ++side) longer[side] += factor * static_cast<double>(last[side].x);
    with_tail.push_back(longer);
    without.push_back(all);
    errors.push_back({0, 0, 0, rig.field().tail().error, static_cast<double>(rig.field().tail().lambda.x)});
  }
  const std::vector<AtlasTexel> sides = rig.surfaces().atlas.texels().download();
  const std::vector<uint32_t> instances = rig.instances();
  const std::vector<double>& truth = with_tail.back();
  const auto error = [&](const std::vector<double>& found, bool sent) {
    double wrong = 0, all = 0;
    for (size_t side = 0; side < found.size(); ++side) {
      const double albedo = sent ? albedos[instances[side]] : 1;
      const double weight = static_cast<double>(sides[side].area) * albedo * albedo;
      wrong += weight * (found[side] - truth[side]) * (found[side] - truth[side]);
      all += weight * truth[side] * truth[side];
    }
    return std::sqrt(wrong / all);
  };
  for (size_t i = 0; i < errors.size(); ++i) {
    errors[i].with_tail = error(with_tail[i], false);
    errors[i].without = error(without[i], false);
    errors[i].sent = error(with_tail[i], true);
  }
  return errors;
}

void check_bounds(const std::vector<Errors>& errors) {
  // Where rounding to single precision is not yet what remains.
  for (size_t i = 2; i < errors.size() && errors[i].bound > 1e-5; ++i) {
    CAPTURE(i);
    CHECK(errors[i].sent < errors[i].bound);
  }
}

}  // namespace

TEST_CASE("a box of reflectances 0.25 to 0.9 needs half the sweeps by its tail, and the bound holds throughout") {
  LampBox box;
  box.mirror = false;
  box.lamp_x[0] = 0;
  box.lamp_x[1] = box.lamp_z[0] = 1. / 3;
  box.lamp_z[1] = 2. / 3;
  const std::vector<Errors> errors = errors_by_sweep(box.scene(), {0.25, 0.9, 0.6, 0.7, 0.5, 0.7, 0.7}, 216, 40);
  for (const size_t sweeps : {5u, 6u, 10u}) {
    const Errors& e = errors[sweeps - 1];
    MESSAGE(sweeps, " sweeps: ", e.with_tail, ", bound ", e.bound, ", without ", e.without, ", lambda ", e.lambda);
  }
  CHECK(errors[9].lambda == relative(0.6, 0.03));
  CHECK(errors[4].with_tail == relative(0.0016, 0.3));
  CHECK(errors[4].bound == relative(0.0074, 0.3));
  CHECK(errors[4].without == relative(0.057, 0.3));
  CHECK(errors[5].with_tail == relative(0.00045, 0.3));
  CHECK(errors[5].bound == relative(0.0020, 0.3));
  CHECK(errors[5].without == relative(0.034, 0.3));
  CHECK(errors[9].without == relative(0.0046, 0.3));
  check_bounds(errors);
}

TEST_CASE("two rooms with a gap between them, by their tail") {
  LampBox box;
  box.mirror = false;
  box.albedo.fill(0.85);
  box.lamp_x[0] = 0;
  box.lamp_x[1] = box.lamp_z[0] = 1. / 3;
  box.lamp_z[1] = 2. / 3;
  Scene scene = box.scene();
  SceneMaterial sheet = test::lambert(0.85f);
  sheet.double_sided = true;
  test::add_polygon(scene, {{0.5f, 0, 0}, {0.5f, 0, 0.8f}, {0.5f, 1, 0.8f}, {0.5f, 1, 0}},
                    test::add_material(scene, sheet));
  const std::vector<Errors> errors = errors_by_sweep(std::move(scene), std::vector<double>(8, 0.85), 274, 90);
  for (const size_t sweeps : {17u, 19u, 32u}) {
    const Errors& e = errors[sweeps - 1];
    MESSAGE(sweeps, " sweeps: ", e.with_tail, ", bound ", e.bound, ", without ", e.without, ", lambda ", e.lambda);
  }
  CHECK(errors[16].with_tail == relative(0.0047, 0.3));
  CHECK(errors[16].bound == relative(0.0073, 0.3));
  CHECK(errors[16].without == relative(0.052, 0.3));
  CHECK(errors[18].with_tail == relative(0.0029, 0.3));
  CHECK(errors[18].bound == relative(0.0045, 0.3));
  CHECK(errors[18].without == relative(0.037, 0.3));
  CHECK(errors[31].without == relative(0.0045, 0.3));
  check_bounds(errors);
}
