#include "server/ingest/inspect/dense_error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "server/ingest/measure/triangle_grid.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/number_table.h"
#include "server/store/export.h"

namespace lode::ingest {
namespace {

constexpr size_t kLeastSamplesOfLeaf = 64;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Lattice coordinates from a node's corner, refined by a power of two, so that points between lattice points
/// have codes as well.
class LocalFrame {
 public:
  explicit LocalFrame(const LatticeBox& box) : origin_(box.min) {
    const glm::uvec3 size = box.max - box.min;
    refinement_ = std::bit_floor(kMaxLattice / std::max({size.x, size.y, size.z, 1u}));
  }

  float refinement() const noexcept { return static_cast<float>(refinement_); }
  glm::uvec3 local(PositionCode position) const noexcept { return local(unpackPosition(position)); }
  glm::uvec3 local(glm::uvec3 position) const noexcept { return (position - origin_) * refinement_; }

  NodeMesh toLocal(const Mesh& mesh) const {
    NodeMesh local_mesh;
    for (const PositionCode position : mesh.positions) {
      local_mesh.wedge_position.push_back(static_cast<uint32_t>(local_mesh.positions.size()));
      local_mesh.positions.push_back(packPosition(local(position)));
    }
    local_mesh.triangles = mesh.triangles;
    return local_mesh;
  }

 private:
  glm::uvec3 origin_;
  uint32_t refinement_;
};

/// Pseudo-random numbers from 0 to 1, the same everywhere.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(NumberTable::hash(seed + 1)) {}
  double roll() noexcept {
    state_ += 0x9e3779b97f4a7c15ULL;
    return static_cast<double>(NumberTable::hash(state_) >> 11) * 0x1p-53;
  }

 private:
  uint64_t state_;
};

glm::dvec3 cornerOf(const NodeMesh& mesh, uint32_t corner) {
  return glm::dvec3(unpackPosition(mesh.positions[corner]));
}

/// Points inside a mesh's triangles, as many in each as its area asks for.
std::vector<PositionCode> samplePoints(const NodeMesh& mesh, size_t count, Dice& dice) {
  std::vector<double> areas;
  double total = 0;
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::dvec3 a = cornerOf(mesh, t.x);
    areas.push_back(glm::length(glm::cross(cornerOf(mesh, t.y) - a, cornerOf(mesh, t.z) - a)));
    total += areas.back();
  }
  std::vector<PositionCode> points;
  double due = dice.roll();
  for (size_t i = 0; i < mesh.triangles.size() && total > 0; ++i) {
    const glm::u32vec3& t = mesh.triangles[i];
    for (due += areas[i] / total * static_cast<double>(count); due >= 1; due -= 1) {
      double u = dice.roll(), v = dice.roll();
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const glm::dvec3 a = cornerOf(mesh, t.x);
      const glm::dvec3 point = a + u * (cornerOf(mesh, t.y) - a) + v * (cornerOf(mesh, t.z) - a);
      points.push_back(packPosition(glm::uvec3(glm::round(point))));
    }
  }
  return points;
}

float distanceToBox(PositionCode point, glm::uvec3 min, glm::uvec3 max) {
  const glm::vec3 at(unpackPosition(point));
  return glm::length(glm::max(glm::max(glm::vec3(min) - at, at - glm::vec3(max)), 0.f));
}

class Measurement {
 public:
  Measurement(const store::Reader& reader, const Node& node, uint32_t rung, size_t samples, uint64_t seed)
      : reader_(reader), frame_(node.box), samples_(samples), dice_(seed) {
    for (const Node& leaf : reader.nodes()) {
      if (leaf.isLeaf() && node.key.contains(leaf.key)) leaves_.push_back(&leaf);
    }
    rung_ = frame_.toLocal(store::readRung(reader, node, rung));
    result_.stored_steps = static_cast<float>(node.rungs[rung].error_model / reader.summary().lattice.step);
  }

  DenseError run() {
    const TriangleGrid rung_grid(rung_);
    const size_t samples_of_leaf = std::max(kLeastSamplesOfLeaf, samples_ / leaves_.size());
    points_ = samplePoints(rung_, samples_, dice_);
    nearest_.assign(points_.size(), kInfinity);
    float forward = 0;
    const float within = result_.stored_steps * frame_.refinement();
    for (const Node* leaf : leaves_) {
      const NodeMesh mesh = frame_.toLocal(store::readRung(reader_, *leaf, 0));
      for (const PositionCode point : samplePoints(mesh, samples_of_leaf, dice_)) {
        forward = std::max(forward, rung_grid.distance(point));
      }
      search(*leaf, &mesh, within);
    }
    // Only points farther from the original surface than the stored error are not settled yet.
    for (const Node* leaf : leaves_) search(*leaf, nullptr, kInfinity);
    for (const float distance : nearest_) result_.backward_steps = std::max(result_.backward_steps, distance);
    result_.backward_steps /= frame_.refinement();
    result_.forward_steps = forward / frame_.refinement();
    return result_;
  }

 private:
  /// Brings the rung's points nearer that are within a distance of a leaf's box.
  /// @param mesh  the leaf's, or null to read it if a point needs it.
  void search(const Node& leaf, const NodeMesh* mesh, float within) {
    const LatticeBox& box = leaf.box;
    const glm::uvec3 min = frame_.local(box.min), max = frame_.local(box.max);
    std::vector<size_t> near;
    for (size_t i = 0; i < points_.size(); ++i) {
      const float away = distanceToBox(points_[i], min, max);
      if (away <= within && away < nearest_[i] && (mesh || nearest_[i] > settled_)) near.push_back(i);
    }
    if (mesh) settled_ = within;
    if (near.empty()) return;
    const TriangleGrid grid(mesh ? *mesh : frame_.toLocal(store::readRung(reader_, leaf, 0)));
    for (const size_t i : near) nearest_[i] = std::min(nearest_[i], grid.distance(points_[i]));
  }

  const store::Reader& reader_;
  const LocalFrame frame_;
  const size_t samples_;
  Dice dice_;
  std::vector<const Node*> leaves_;
  NodeMesh rung_;
  std::vector<PositionCode> points_;
  std::vector<float> nearest_;
  float settled_ = 0;  ///< a point this near has met all leaves that could be nearer
  DenseError result_;
};

}  // namespace

DenseError measureDenseError(const store::Reader& reader, const Node& node, uint32_t rung, size_t samples,
                             uint64_t seed) {
  return Measurement(reader, node, rung, samples, seed).run();
}

}  // namespace lode::ingest
