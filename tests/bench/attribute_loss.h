#pragma once

#include <map>
#include <span>
#include <vector>

#include "tests/bench/bench_models.h"

namespace lode::bench {

/// Differences of a simplified mesh's attributes from its original's at nearest points, means over both
/// surfaces' areas.
struct AttributeLoss {
  double colour = 0;        ///< of a channel, of 255
  double normal_deg = 0;    ///< angle
  double texture = 0;       ///< of a coordinate, steps of the texture grid; of samples in one chart
  double other_charts = 0;  ///< share of samples whose nearest point lies beyond a texture seam
  double surface = 0;       ///< two-sided rms, of the box diagonal
};

/// A mesh that is asked for the attributes of its point nearest to a place. Thread safe.
class AttributeField {
 public:
  explicit AttributeField(const ingest::NodeMesh& mesh);

  /// Channels that the loss looks at.
  struct Value {
    glm::dvec3 colour{0}, normal{0};
    glm::dvec2 texture{0};
    uint16_t material = 0;
  };
  /// @param hint  see test::DistanceField.
  Value at(glm::dvec3 point, uint32_t& hint, double& distance) const;
  const test::TriangleSoup& soup() const { return soup_; }

 private:
  Value mix(uint32_t triangle, glm::dvec3 share) const;

  const ingest::NodeMesh& mesh_;
  test::TriangleSoup soup_;
  test::DistanceField field_;
  struct Less {
    bool operator()(const test::Triangle3& s, const test::Triangle3& t) const;
  };
  std::map<test::Triangle3, uint32_t, Less> number_;  ///< of the mesh's triangles; of equal ones the last
};

/// @param original, simple  in steps of one lattice.
AttributeLoss attributeLoss(const AttributeField& original, const ingest::NodeMesh& simple, size_t samples);

}  // namespace lode::bench
