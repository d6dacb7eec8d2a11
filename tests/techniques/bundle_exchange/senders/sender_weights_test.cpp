// SPDX-License-Identifier: Apache-2.0
// The recurrence of interleaved bounces in a closed body of albedo ρ, where every texel side receives what all send:
// deficits after N directions against their closed forms.
#include "bundle_exchange/senders/sender_weights.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tolerance.h"

using namespace lucarium::bundle;

namespace {

struct Means {
  double sender = 0, sender_weight = 0, display = 0, display_weight = 0;
};

/// Emission 1 beside albedo ρ: what is sent is 1 + ρ E/π, whose limit is 1 / (1 - ρ). Returns the relative deficit of
/// D.
double furnace_deficit(const Parameters& parameters, double rho, int directions, int batch, bool fixed = false) {
  SenderWeights weights(parameters);
  Means m;
  for (int i = 0; i < directions; i += batch) {
    const double held = m.sender_weight > 0 ? m.sender / m.sender_weight : 0;
    const double received = 1 + rho * held * (fixed ? double(i) / directions : 1.0);
    const SenderWeights::Step step = weights.next(i, batch);
    weights.advance();
    m.sender = m.sender * step.sender_scale + step.sender_weight * batch * received;
    m.sender_weight = m.sender_weight * step.sender_scale + step.sender_weight * batch;
    m.display += step.display_weight * batch * received;
    m.display_weight += step.display_weight * batch;
  }
  return m.display / m.display_weight * (1 - rho) - 1;
}

}  // namespace

TEST_CASE("forgetting senders leave 0.1 % after 2048 directions") {
  Parameters parameters;
  CHECK(furnace_deficit(parameters, 0.8, 2048, 1) == lucarium::test::relative(-0.0010, 0.1));
  CHECK(furnace_deficit(parameters, 0.8, 2048, 4) == lucarium::test::relative(-0.008, 0.15));
}

TEST_CASE("a running mean leaves what the gamma function says") {
  Parameters parameters;
  parameters.interleave = Interleave::running;
  for (const double rho : {0.5, 0.8}) {
    const int n = 2048;
    const double expected = std::exp(std::lgamma(n + rho) - std::lgamma(rho) - std::lgamma(n + 1.0));
    CHECK(furnace_deficit(parameters, rho, n, 1) == lucarium::test::relative(-expected, 0.1));
  }
}

TEST_CASE("equal shares of the total never reach the limit") {
  Parameters parameters;
  parameters.interleave = Interleave::fixed;
  const double rho = 0.8, limit = (std::exp(rho) - 1) / rho * (1 - rho) - 1;
  CHECK(furnace_deficit(parameters, rho, 20000, 1, true) == lucarium::test::relative(limit, 0.01));
}

TEST_CASE("weights stay in single precision over a million batches and forget as they should") {
  Parameters parameters;
  SenderWeights weights(parameters);
  double total = 0, share = 0;
  for (int i = 0; i < 1000000; ++i) {
    const SenderWeights::Step step = weights.next(i, 1);
    weights.advance();
    REQUIRE_UNARY(step.sender_weight < 1e27);
    total = total * step.sender_scale + step.sender_weight;
    share = step.sender_weight / total;
    if (i == 99 || i == 9999 || i == 999999) CHECK(share == lucarium::test::relative(std::pow(i + 1.0, -0.5), 1e-6));
  }
}
