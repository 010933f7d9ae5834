#include "server/ingest/simplify/collapse_check.h"

#include <algorithm>

namespace lode::ingest {

bool CollapseCheck::keepsShape(uint32_t corner, glm::dvec3 from, glm::dvec3 to,
                               const CollapseLimits& limits) const {
  const glm::dvec3 a = mesh_.point(mesh_.at(CollapseMesh::next(corner)));
  const glm::dvec3 b = mesh_.point(mesh_.at(CollapseMesh::previous(corner)));
  const glm::dvec3 side = b - a, old_side = from - a, new_side = to - a;
  const glm::dvec3 old_normal = glm::cross(side, old_side), new_normal = glm::cross(side, new_side);
  const double old_square = glm::dot(old_normal, old_normal), new_square = glm::dot(new_normal, new_normal);
  if (old_square == 0) return true;
  const double cosine = glm::dot(old_normal, new_normal);
  const double bound = limits.least_cosine * limits.least_cosine * old_square * new_square;
  if (limits.least_cosine >= 0 ? cosine <= 0 || cosine * cosine < bound
                               : cosine < 0 && cosine * cosine > bound) {
    return false;
  }
  const auto longest = [&](glm::dvec3 other_side, glm::dvec3 end) {
    return std::max({glm::dot(side, side), glm::dot(other_side, other_side), glm::dot(b - end, b - end)});
  };
  const double new_longest = longest(new_side, to);
  if (new_square >= limits.least_shape * limits.least_shape * new_longest * new_longest) return true;
  const double old_longest = longest(old_side, from);
  return new_square * old_longest * old_longest >= old_square * new_longest * new_longest;
}

double CollapseCheck::areaOfOthers(uint32_t u, uint32_t a, uint32_t b) const {
  for (const uint32_t corner : mesh_.around(u)) {
    const uint32_t c = mesh_.at(CollapseMesh::next(corner));
    const uint32_t d = mesh_.at(CollapseMesh::previous(corner));
    if ((c != a || d != b) && (c != b || d != a)) continue;
    return glm::length(glm::cross(mesh_.point(a) - mesh_.point(u), mesh_.point(b) - mesh_.point(u)));
  }
  return -1;
}

CollapseFinding CollapseCheck::look(uint32_t u, uint32_t v, glm::dvec3 to, const CollapseLimits& limits) {
  CollapseFinding finding;
  if (mesh_.positions[u].count + mesh_.positions[v].count > limits.most_triangles) {
    finding.removed = 1;
    return finding;
  }
  const std::vector<uint32_t>& position = mesh_.corner_position;
  stamp_ += kMarks;
  const glm::dvec3 at_u = mesh_.point(u), at_v = mesh_.point(v);
  const bool moves_u = to != at_u, moves_v = to != at_v;
  bool shapes = true;
  uint32_t apexes = 0, common = 0;
  for (const uint32_t corner : mesh_.around(u)) {
    const uint32_t a = position[CollapseMesh::next(corner)], b = position[CollapseMesh::previous(corner)];
    if (a == v || b == v) {
      ++finding.removed;
    } else if (moves_u && shapes) {
      shapes = keepsShape(corner, at_u, to, limits);
    }
    marks_[a] = marks_[b] = stamp_;
  }
  if (finding.removed == 0 || !shapes) return finding;
  for (const uint32_t corner : mesh_.around(v)) {
    const uint32_t a = position[CollapseMesh::next(corner)], b = position[CollapseMesh::previous(corner)];
    if (a == u || b == u) {
      const uint32_t apex = a == u ? b : a;
      if (marks_[apex] == stamp_) ++common;
      if (marks_[apex] != stamp_ + kApex) ++apexes;
      marks_[apex] = stamp_ + kApex;
      continue;
    }
    if (moves_v && !keepsShape(corner, at_v, to, limits)) return finding;
    bool both = true;
    for (const uint32_t w : {a, b}) {
      both &= marks_[w] >= stamp_;
      if (marks_[w] != stamp_) continue;
      ++common;
      marks_[w] = stamp_ + kCounted;
    }
    if (!both) continue;
    const double area = areaOfOthers(u, a, b);
    if (area < 0) continue;
    finding.folds = true;
    finding.folded_area += area;
  }
  finding.allowed = !limits.link_condition || common == apexes;
  return finding;
}

}  // namespace lode::ingest
