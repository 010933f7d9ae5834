#pragma once

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"

namespace lode::ingest {

struct Segment {
  glm::vec3 from, to;
};

struct FourSegments {
  FourVectors from, to;
};

/// Returns the squared distance between each segment of `p` and the corresponding segment of `q`. One of the
/// two may be a point. Source: Ericson, Real-Time Collision Detection, 2005, 5.1.9.
inline Four squaredDistances(const FourSegments& p, const FourSegments& q) noexcept {
  const FourVectors along_p = p.to - p.from, along_q = q.to - q.from, between = p.from - q.from;
  const Four pp = dot(along_p, along_p), qq = dot(along_q, along_q), pq = dot(along_p, along_q);
  const Four pb = dot(along_p, between), qb = dot(along_q, between);
  const auto share = [zero = Four{}, one = fourOf(1)](Four part, Four whole) {
    return whole > zero ? smaller(larger(part / whole, zero), one) : zero;
  };
  // Position on p, from 0 to 1, that is nearest to the infinite line through q; 0 if p and q are parallel.
  const Four of_p = share(pq * qb - pb * qq, pp * qq - pq * pq);
  const Four of_q = share(pq * of_p + qb, qq);
  // Position on p that is nearest to the point on q. This position differs from of_p if the point on q was
  // clamped to an end.
  const Four back = share(pq * of_q - pb, pp);
  const FourVectors away = between + back * along_p - of_q * along_q;
  return dot(away, away);
}

}  // namespace lode::ingest
