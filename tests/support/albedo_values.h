// SPDX-License-Identifier: Apache-2.0
// Albedos of the specular lobe (height-correlated Smith, alpha = roughness squared) by quadrature, to the digits given.
#pragma once

namespace lucarium::test {

/// The cosines of the columns.
inline constexpr double albedo_cosines[6] = {1, .8, .6, .4, .2, .1};

struct AlbedoRow {
  float roughness;
  double values[6];
};

/// E1: F = 1.
inline constexpr AlbedoRow e1_rows[] = {
    {.1f, {.99990, .99987, .99981, .99962, .99859, .99412}}, {.2f, {.99830, .99778, .99664, .99324, .97515, .92899}},
    {.3f, {.99067, .98768, .98129, .96456, .91403, .88432}}, {.5f, {.91581, .89727, .87172, .84427, .84816, .89162}},
    {.7f, {.69775, .69055, .69455, .72107, .79272, .86191}}, {1.f, {.30685, .35126, .41150, .49889, .64165, .76021}}};

/// B: F = (1 - v.h)^5.
inline constexpr AlbedoRow b_rows[] = {{.2f, {.00000, .00046, .01113, .07729, .29695, .46966}},
                                       {.5f, {.00003, .00151, .01095, .04019, .09826, .13969}},
                                       {1.f, {.00003, .00043, .00169, .00508, .01403, .02387}}};

/// What their last digit leaves open; rounded, ±0.5 of it.
inline constexpr double albedo_rounding = 1e-5;

/// Averages over the cosine.
struct AverageAlbedo {
  float roughness;
  double e1, b;
  double dielectric;  ///< for F0 = .04
};
inline constexpr AverageAlbedo average_albedos[] = {{.1f, .99949, .0471, .0852}, {.2f, .99406, .0431, .0812},
                                                    {.3f, .97651, .0354, .0731}, {.5f, .88232, .0187, .0532},
                                                    {.7f, .70743, .0086, .0365}, {1.f, .40914, .0028, .0190}};

/// The row of a roughness.
template <class Row, int N>
constexpr const Row& row_of(const Row (&rows)[N], float roughness) {
  for (const Row& row : rows)
    if (row.roughness == roughness) return row;
  throw "no such row";
}

/// Albedo of a dielectric of F0 = .04 and diffuse colour `base`, for a column: c (1 - Ebar) + F0 (E1 - B) + B.
constexpr double dielectric_albedo(double base, float roughness, int column) {
  const double b = row_of(b_rows, roughness).values[column], e1 = row_of(e1_rows, roughness).values[column];
  return base * (1 - row_of(average_albedos, roughness).dielectric) + 0.04 * (e1 - b) + b;
}

}  // namespace lucarium::test
