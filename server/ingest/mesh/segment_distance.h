#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace lode::ingest {

struct Segment {
  glm::vec3 from, to;
};

/// Square of the distance between two segments; one of them may be a point.
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.9.
inline float squaredDistance(const Segment& p, const Segment& q) noexcept {
  const glm::vec3 along_p = p.to - p.from, along_q = q.to - q.from, between = p.from - q.from;
  const float pp = glm::dot(along_p, along_p), qq = glm::dot(along_q, along_q),
              pq = glm::dot(along_p, along_q);
  const float pb = glm::dot(along_p, between), qb = glm::dot(along_q, between);
  const auto share = [](float part, float whole) {
    return whole > 0 ? std::clamp(part / whole, 0.f, 1.f) : 0.f;
  };
  const float of_p = share(pq * qb - pb * qq, pp * qq - pq * pq);  // of the lines; 0 where they are parallel
  const float of_q = share(pq * of_p + qb, qq);
  const float back = share(pq * of_q - pb, pp);  // nearest to that place of q, should it be an end
  const glm::vec3 away = between + back * along_p - of_q * along_q;
  return glm::dot(away, away);
}

}  // namespace lode::ingest
