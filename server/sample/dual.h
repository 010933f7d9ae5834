#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A number with its derivatives along the two parameters of a surface, so that a surface written as plain
/// arithmetic has exact tangents. Source: forward automatic differentiation.
struct Dual {
  double value = 0;
  glm::dvec2 slope{0};

  constexpr Dual(double constant = 0) : value(constant) {}  // NOLINT(google-explicit-constructor): a constant
  constexpr Dual(double v, const glm::dvec2& s) : value(v), slope(s) {}

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.slope + b.value * a.slope};
  }
};

/// A function of a dual number, by its value and derivative there.
inline Dual apply(const Dual& at, double value, double derivative) { return {value, derivative * at.slope}; }

inline Dual abs(const Dual& a) { return a.value < 0 ? Dual(0) - a : a; }

/// From 0 at `from` to 1 at `to`, level outside.
inline Dual smoothStep(double from, double to, const Dual& a) {
  const double t = (a.value - from) / (to - from);
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  return apply(a, t * t * (3 - 2 * t), 6 * t * (1 - t) / (to - from));
}

/// The larger of two, rounded where they differ by less than `radius`.
inline Dual smoothMax(const Dual& a, const Dual& b, double radius) {
  const double gap = radius - std::abs(a.value - b.value);
  const Dual& larger = a.value > b.value ? a : b;
  if (gap <= 0) return larger;
  const Dual overlap = Dual(radius) - abs(a - b);
  return larger + overlap * overlap * Dual(1 / (4 * radius));
}

}  // namespace lode::ingest
