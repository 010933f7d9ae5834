#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <vector>

#include "tests/bench/attribute_forms.h"

namespace lode::bench {

/// Vertices with attributes as lengths; those that must stay are locked.
template <size_t K>
struct FormMesh {
  std::vector<Place<K>> vertices;
  std::vector<bool> locked;
  std::vector<glm::u32vec3> triangles;
};

/// A plain edge collapse, the same for both forms: a queue by cost, no flips, no change of topology.
template <typename Form, size_t K>
class FormCollapse {
 public:
  explicit FormCollapse(FormMesh<K> mesh)
      : mesh_(std::move(mesh)),
        forms_(mesh_.vertices.size()),
        around_(mesh_.vertices.size()),
        changes_(mesh_.vertices.size()) {
    for (uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const glm::u32vec3 t = mesh_.triangles[i];
      const double area = 0.5 * glm::length(normalOf(t));
      for (int k = 0; k < 3; ++k) {
        around_[t[k]].push_back(i);
        if (area > 0) forms_[t[k]].addTriangle(at(t.x), at(t.y), at(t.z), area);
        ingest::Quadric point;
        point.addPoint(at(t[k]).position, kPointWeight * area);
        forms_[t[k]].addPositions(point);
      }
    }
    live_ = mesh_.triangles.size();
    addBoundaries();
  }

  /// @return the mesh with at most so many triangles, or as few as it gets.
  FormMesh<K> run(size_t triangles) {
    for (uint32_t v = 0; v < around_.size(); ++v) pushEdges(v, true);
    while (live_ > triangles && !queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (entry.changes == changes_[entry.u] + changes_[entry.v] && !around_[entry.u].empty() &&
          !around_[entry.v].empty())
        tryJoin(entry.u, entry.v);
    }
    std::erase_if(mesh_.triangles, [](glm::u32vec3 t) { return t.x == t.y; });
    return std::move(mesh_);
  }

 private:
  static constexpr double kPointWeight = 1e-6, kBoundaryWeight = 2, kLeastCosine = 0.2;
  struct Entry {
    double cost;
    uint32_t u, v, changes;
    bool operator<(const Entry& other) const {
      return cost != other.cost ? cost > other.cost : u != other.u ? u > other.u : v > other.v;
    }
  };

  const Place<K>& at(uint32_t v) const { return mesh_.vertices[v]; }
  glm::dvec3 normalOf(glm::u32vec3 t) const {
    return glm::cross(at(t.y).position - at(t.x).position, at(t.z).position - at(t.x).position);
  }
  static bool has(glm::u32vec3 t, uint32_t v) { return t.x == v || t.y == v || t.z == v; }

  size_t uses(uint32_t u, uint32_t v) const {
    return static_cast<size_t>(std::count_if(around_[u].begin(), around_[u].end(),
                                             [&](uint32_t t) { return has(mesh_.triangles[t], v); }));
  }

  void addBoundaries() {
    for (const glm::u32vec3 t : mesh_.triangles) {
      for (int k = 0; k < 3; ++k) {
        const uint32_t u = t[k], v = t[(k + 1) % 3];
        if (uses(u, v) == 2) continue;
        const glm::dvec3 along = at(v).position - at(u).position, across = glm::cross(along, normalOf(t));
        const double length = glm::length(across);
        if (length == 0) continue;
        ingest::Quadric boundary;
        boundary.addPlane(across / length, -glm::dot(across / length, at(u).position),
                          kBoundaryWeight * glm::dot(along, along));
        forms_[u].addPositions(boundary);
        forms_[v].addPositions(boundary);
      }
    }
  }

  std::vector<uint32_t> neighbours(uint32_t v) const {
    std::vector<uint32_t> result;
    for (const uint32_t t : around_[v])
      for (int k = 0; k < 3; ++k)
        if (mesh_.triangles[t][k] != v) result.push_back(mesh_.triangles[t][k]);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  Joined<K> join(uint32_t u, uint32_t v) const {
    Form sum = forms_[u];
    sum.add(forms_[v]);
    if (mesh_.locked[u]) return {at(u), sum.at(at(u))};
    if (mesh_.locked[v]) return {at(v), sum.at(at(v))};
    return sum.best(at(u), at(v));
  }

  void pushEdges(uint32_t v, bool only_larger) {
    for (const uint32_t other : neighbours(v)) {
      if ((only_larger && other < v) || (mesh_.locked[v] && mesh_.locked[other])) continue;
      queue_.push({join(v, other).cost, v, other, changes_[v] + changes_[other]});
    }
  }

  bool keepsNormals(uint32_t v, uint32_t other, glm::dvec3 to) const {
    return std::all_of(around_[v].begin(), around_[v].end(), [&](uint32_t number) {
      const glm::u32vec3 t = mesh_.triangles[number];
      if (has(t, other)) return true;
      std::array<glm::dvec3, 3> p;
      for (int k = 0; k < 3; ++k) p[static_cast<size_t>(k)] = t[k] == v ? to : at(t[k]).position;
      const glm::dvec3 before = normalOf(t), after = glm::cross(p[1] - p[0], p[2] - p[0]);
      return glm::dot(before, after) > kLeastCosine * glm::length(before) * glm::length(after);
    });
  }

  void tryJoin(uint32_t u, uint32_t v) {
    const std::vector<uint32_t> a = neighbours(u), b = neighbours(v);
    std::vector<uint32_t> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.size() != uses(u, v)) return;
    const Joined<K> joined = join(u, v);
    if (!keepsNormals(u, v, joined.place.position) || !keepsNormals(v, u, joined.place.position)) return;
    for (const uint32_t number : around_[v]) {
      glm::u32vec3& t = mesh_.triangles[number];
      if (has(t, u)) {
        for (int k = 0; k < 3; ++k)
          if (t[k] != v) std::erase(around_[t[k]], number);
        t = glm::u32vec3(0);
        --live_;
      } else {
        for (int k = 0; k < 3; ++k)
          if (t[k] == v) t[k] = u;
        around_[u].push_back(number);
      }
    }
    around_[v].clear();
    mesh_.vertices[u] = joined.place;
    mesh_.locked[u] = mesh_.locked[u] || mesh_.locked[v];
    forms_[u].add(forms_[v]);
    ++changes_[u];
    pushEdges(u, false);
  }

  FormMesh<K> mesh_;
  std::vector<Form> forms_;
  std::vector<std::vector<uint32_t>> around_;
  std::vector<uint32_t> changes_;
  std::priority_queue<Entry> queue_;
  size_t live_ = 0;
};

}  // namespace lode::bench
