// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <doctest/doctest.h>

#include <cmath>
#include <type_traits>

namespace lucarium::test {

/// A number, and how far from it another may be to count as equal. doctest's own Approx is not for tests here: its
/// epsilon e allows e · (1 + |x|), which is an absolute tolerance for every x below about one.
struct Tolerance {
  double expected, allowed;

  template <class T>
  requires std::is_arithmetic_v<T>
  friend bool operator==(T value, const Tolerance& t) {
    return std::abs(static_cast<double>(value) - t.expected) <= t.allowed;  // false for NaN
  }
};

/// Equal to `expected` up to `error` · |expected|; the error it has if none is given is for single precision.
inline Tolerance relative(double expected, double error = 1e-5) { return {expected, error * std::abs(expected)}; }

/// Equal to `expected` up to ± `error`, in its unit.
inline Tolerance within(double expected, double error) { return {expected, error}; }

inline doctest::String toString(const Tolerance& t) {
  return doctest::toString(t.expected) + " +- " + doctest::toString(t.allowed);
}

}  // namespace lucarium::test
