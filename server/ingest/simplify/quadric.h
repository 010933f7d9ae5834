#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Sum of weighted squared distances from planes and points: Q(p) = p'Ap + 2 b'p + c, with A symmetric and
/// positive semi-definite.
/// Source: Garland & Heckbert, Surface Simplification Using Quadric Error Metrics, 1997.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  // elements of A
  glm::dvec3 b{0};
  double c = 0;

  /// Adds weight * (dot(normal, p) + offset)^2.
  void addPlane(glm::dvec3 normal, double offset, double weight) noexcept {
    const glm::dvec3 n = weight * normal;
    xx += n.x * normal.x;
    xy += n.x * normal.y;
    xz += n.x * normal.z;
    yy += n.y * normal.y;
    yz += n.y * normal.z;
    zz += n.z * normal.z;
    b += offset * n;
    c += weight * offset * offset;
  }

  /// Adds weight * |p - point|^2.
  void addPoint(glm::dvec3 point, double weight) noexcept {
    xx += weight;
    yy += weight;
    zz += weight;
    b -= weight * point;
    c += weight * glm::dot(point, point);
  }

  /// Subtracts weight * other.
  void subtract(const Quadric& other, double weight) noexcept {
    xx -= weight * other.xx;
    xy -= weight * other.xy;
    xz -= weight * other.xz;
    yy -= weight * other.yy;
    yz -= weight * other.yz;
    zz -= weight * other.zz;
    b -= weight * other.b;
    c -= weight * other.c;
  }

  Quadric& operator+=(const Quadric& q) noexcept {
    xx += q.xx;
    xy += q.xy;
    xz += q.xz;
    yy += q.yy;
    yz += q.yz;
    zz += q.zz;
    b += q.b;
    c += q.c;
    return *this;
  }
  friend Quadric operator+(Quadric q, const Quadric& r) noexcept { return q += r; }

  glm::dvec3 timesA(glm::dvec3 p) const noexcept {
    return {xx * p.x + xy * p.y + xz * p.z, xy * p.x + yy * p.y + yz * p.z, xz * p.x + yz * p.y + zz * p.z};
  }
  /// Total weight of the planes, if their normals have length 1.
  double weight() const noexcept { return xx + yy + zz; }
  double at(glm::dvec3 p) const noexcept { return glm::dot(p, timesA(p) + 2.0 * b) + c; }
};

/// A point, and the quadric's value at this point.
struct Placement {
  glm::dvec3 point;
  double cost;
};

/// Returns the point with the smallest value on the segment from u to v.
inline Placement bestOnSegment(const Quadric& q, glm::dvec3 u, glm::dvec3 v) noexcept {
  const glm::dvec3 along = v - u;
  const double curvature = glm::dot(along, q.timesA(along));
  Placement best{u, q.at(u)};
  if (const double cost = q.at(v); cost < best.cost) best = {v, cost};
  if (curvature > 0) {
    const double t = -glm::dot(along, q.timesA(u) + q.b) / curvature;
    if (t > 0 && t < 1) {
      const glm::dvec3 point = u + t * along;
      if (const double cost = q.at(point); cost < best.cost) best = {point, cost};
    }
  }
  return best;
}

/// Returns the minimum of a quadric near the edge (u, v). Returns the best point on the edge if the quadric
/// is ill-conditioned, or if the minimum is farther from the edge's middle than the edge is long. Coordinates
/// relative to the edge's middle keep the precision far from the origin.
inline Placement bestPlacement(const Quadric& q, glm::dvec3 u, glm::dvec3 v) noexcept {
  constexpr double kSmallestDeterminant = 1e-14;  // relative to the cube of the trace of A
  const glm::dvec3 middle = 0.5 * (u + v), along = v - u;
  const glm::dvec3 half_gradient = q.timesA(middle) + q.b;
  const double c00 = q.yy * q.zz - q.yz * q.yz, c01 = q.xz * q.yz - q.xy * q.zz,
               c02 = q.xy * q.yz - q.xz * q.yy, c11 = q.xx * q.zz - q.xz * q.xz,
               c12 = q.xy * q.xz - q.xx * q.yz, c22 = q.xx * q.yy - q.xy * q.xy;
  const double determinant = q.xx * c00 + q.xy * c01 + q.xz * c02;
  const double trace = q.xx + q.yy + q.zz;
  if (determinant > kSmallestDeterminant * trace * trace * trace) {
    const double scale = -1 / determinant;
    const glm::dvec3 g = half_gradient;
    const glm::dvec3 step =
        scale * glm::dvec3(c00 * g.x + c01 * g.y + c02 * g.z, c01 * g.x + c11 * g.y + c12 * g.z,
                           c02 * g.x + c12 * g.y + c22 * g.z);
    if (glm::dot(step, step) <= glm::dot(along, along)) {
      return {middle + step, glm::dot(middle, half_gradient + q.b) + q.c + glm::dot(step, half_gradient)};
    }
  }
  return bestOnSegment(q, u, v);
}

}  // namespace lode::ingest
