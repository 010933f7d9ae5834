#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/quadric.h"

/// Two forms of quadrics over position and K attributes, which are lengths, for the same driver. Both weigh a
/// triangle by its area. A place is a position and its attributes.
namespace lode::bench {

template <size_t K>
struct Place {
  glm::dvec3 position{0};
  std::array<double, K> values{};
};

/// Of a driver: what joining two vertices costs, and where it puts them.
template <size_t K>
struct Joined {
  Place<K> place;
  double cost = 0;
};

/// Garland and Heckbert 1998: squared distance from the triangle's plane in 3 + K dimensions.
/// Source: Simplifying Surfaces with Color and Texture using Quadric Error Metrics.
template <size_t K>
class OneSpaceForm {
 public:
  void addTriangle(const Place<K>& p, const Place<K>& q, const Place<K>& r, double area) {
    const Vector a = vectorOf(p);
    const Vector e1 = unit(minus(vectorOf(q), a));
    Vector e2 = minus(vectorOf(r), a);
    const double along = dot(e1, e2);
    for (size_t i = 0; i < N; ++i) e2[i] -= along * e1[i];
    e2 = unit(e2);
    const double d1 = dot(a, e1), d2 = dot(a, e2);
    for (size_t i = 0, at = 0; i < N; ++i) {
      for (size_t j = i; j < N; ++j)
        a_[at++] += area * ((i == j ? 1.0 : 0.0) - e1[i] * e1[j] - e2[i] * e2[j]);
      b_[i] += area * (d1 * e1[i] + d2 * e2[i] - a[i]);
    }
    c_ += area * (dot(a, a) - d1 * d1 - d2 * d2);
  }

  void addPositions(const ingest::Quadric& q) {
    a_[0] += q.xx;
    a_[1] += q.xy;
    a_[2] += q.xz;
    a_[N] += q.yy;
    a_[N + 1] += q.yz;
    a_[2 * N - 1] += q.zz;
    for (size_t i = 0; i < 3; ++i) b_[i] += q.b[static_cast<int>(i)];
    c_ += q.c;
  }

  void add(const OneSpaceForm& other) {
    for (size_t i = 0; i < a_.size(); ++i) a_[i] += other.a_[i];
    for (size_t i = 0; i < N; ++i) b_[i] += other.b_[i];
    c_ += other.c_;
  }

  double at(const Place<K>& place) const {
    const Vector v = vectorOf(place);
    double sum = c_;
    for (size_t i = 0, k = 0; i < N; ++i) {
      sum += 2 * b_[i] * v[i];
      for (size_t j = i; j < N; ++j) sum += (i == j ? 1 : 2) * a_[k++] * v[i] * v[j];
    }
    return sum;
  }

  /// The optimum near the edge, else its better end or middle.
  Joined<K> best(const Place<K>& u, const Place<K>& v) const {
    const Place<K> middle = placeOf(half(vectorOf(u), vectorOf(v)));
    Vector step;
    if (solve(gradientAt(middle), step)) {
      Vector moved = vectorOf(middle);
      for (size_t i = 0; i < N; ++i) moved[i] += step[i];
      const Place<K> place = placeOf(moved);
      const glm::dvec3 along = v.position - u.position, away = place.position - middle.position;
      if (glm::dot(away, away) <= glm::dot(along, along)) return {place, at(place)};
    }
    Joined<K> result{u, at(u)};
    for (const Place<K>& other : {v, middle})
      if (const double cost = at(other); cost < result.cost) result = {other, cost};
    return result;
  }

 private:
  static constexpr size_t N = 3 + K;
  using Vector = std::array<double, N>;

  static Vector vectorOf(const Place<K>& p) {
    Vector v{p.position.x, p.position.y, p.position.z};
    for (size_t i = 0; i < K; ++i) v[3 + i] = p.values[i];
    return v;
  }
  static Place<K> placeOf(const Vector& v) {
    Place<K> p{{v[0], v[1], v[2]}, {}};
    for (size_t i = 0; i < K; ++i) p.values[i] = v[3 + i];
    return p;
  }
  static double dot(const Vector& a, const Vector& b) {
    double sum = 0;
    for (size_t i = 0; i < N; ++i) sum += a[i] * b[i];
    return sum;
  }
  static Vector minus(Vector a, const Vector& b) {
    for (size_t i = 0; i < N; ++i) a[i] -= b[i];
    return a;
  }
  static Vector half(Vector a, const Vector& b) {
    for (size_t i = 0; i < N; ++i) a[i] = 0.5 * (a[i] + b[i]);
    return a;
  }
  static Vector unit(Vector v) {
    const double length = std::sqrt(dot(v, v));
    for (double& x : v) x = length > 0 ? x / length : 0;
    return v;
  }
  Vector gradientAt(const Place<K>& place) const {
    const Vector v = vectorOf(place);
    Vector g = b_;
    for (size_t i = 0, k = 0; i < N; ++i) {
      for (size_t j = i; j < N; ++j, ++k) {
        g[i] += a_[k] * v[j];
        if (i != j) g[j] += a_[k] * v[i];
      }
    }
    return g;
  }
  /// A * step = -g by Cholesky's L D L'. @return false where A is ill-conditioned.
  bool solve(const Vector& g, Vector& step) const {
    std::array<Vector, N> l{};
    Vector d{};
    double trace = 0;
    for (size_t i = 0, k = 0; i < N; k += N - i, ++i) trace += a_[k];
    for (size_t j = 0, row = 0; j < N; row += N - j, ++j) {
      d[j] = a_[row];
      for (size_t k = 0; k < j; ++k) d[j] -= l[j][k] * l[j][k] * d[k];
      if (!(d[j] > 1e-10 * trace)) return false;
      for (size_t i = j + 1; i < N; ++i) {
        double sum = a_[row + i - j];
        for (size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k] * d[k];
        l[i][j] = sum / d[j];
      }
    }
    for (size_t i = 0; i < N; ++i) {
      step[i] = -g[i];
      for (size_t k = 0; k < i; ++k) step[i] -= l[i][k] * step[k];
    }
    for (size_t i = N; i-- > 0;) {
      step[i] /= d[i];
      for (size_t k = i + 1; k < N; ++k) step[i] -= l[k][i] * step[k];
    }
    return true;
  }

  std::array<double, N*(N + 1) / 2> a_{};  ///< upper triangle by rows
  Vector b_{};
  double c_ = 0;
};

/// Hoppe 1999: squared distance from the triangle's plane, and of each attribute from what the triangle has
/// at the nearest point of its plane. The same sums as in ingest::WedgeQuadrics. Source: New Quadric Metric
/// for Simplifying Meshes with Appearance Attributes.
template <size_t K>
class GradientForm {
 public:
  void addTriangle(const Place<K>& p, const Place<K>& q, const Place<K>& r, double area) {
    const glm::dvec3 e1 = q.position - p.position, e2 = r.position - p.position;
    const glm::dvec3 normal = glm::cross(e1, e2);
    const double square = glm::dot(normal, normal);
    q_.addPlane(normal, -glm::dot(normal, p.position), area / square);
    const glm::dvec3 along1 = glm::cross(e2, normal) / square, along2 = glm::cross(normal, e1) / square;
    area_ += area;
    for (size_t i = 0; i < K; ++i) {
      const glm::dvec3 g = (q.values[i] - p.values[i]) * along1 + (r.values[i] - p.values[i]) * along2;
      const double d = p.values[i] - glm::dot(g, p.position);
      q_.addPlane(g, d, area);
      g_[i] += area * g;
      d_[i] += area * d;
    }
  }

  void addPositions(const ingest::Quadric& q) { q_ += q; }

  void add(const GradientForm& other) {
    q_ += other.q_;
    area_ += other.area_;
    for (size_t i = 0; i < K; ++i) {
      g_[i] += other.g_[i];
      d_[i] += other.d_[i];
    }
  }

  double at(const Place<K>& place) const {
    double sum = q_.at(place.position);
    for (size_t i = 0; i < K; ++i)
      sum += place.values[i] * (area_ * place.values[i] - 2 * (glm::dot(g_[i], place.position) + d_[i]));
    return sum;
  }

  Joined<K> best(const Place<K>& u, const Place<K>& v) const {
    ingest::Quadric reduced = q_;
    for (size_t i = 0; i < K && area_ > 0; ++i) reduced.addPlane(g_[i], d_[i], -1 / area_);
    const ingest::Placement placement = ingest::bestPlacement(reduced, u.position, v.position);
    Joined<K> result{{placement.point, u.values}, placement.cost};
    for (size_t i = 0; i < K && area_ > 0; ++i)
      result.place.values[i] = (glm::dot(g_[i], placement.point) + d_[i]) / area_;
    return result;
  }

 private:
  ingest::Quadric q_;
  double area_ = 0;
  std::array<glm::dvec3, K> g_{};
  std::array<double, K> d_{};
};

}  // namespace lode::bench
