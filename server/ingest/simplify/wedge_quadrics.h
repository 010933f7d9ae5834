#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/quadric.h"

namespace lode::ingest {

/// Quadrics over position and attributes. Each triangle says, for every attribute s, what it should be at a
/// place p: dot(g, p) + d, with g in the triangle's plane; the error is area * (dot(g, p) + d - s)^2. The
/// squares that do not hold s are planes in the position's Quadric; the rest is, per wedge, the sums of area,
/// area * g and area * d. For any p the best s is (dot(G, p) + D) / W, which leaves a quadric in p alone:
/// Q(p) - sum (dot(G, p) + D)^2 / W.
///
/// Colours and normals and texture coordinates of the file count, as lengths: full range of a colour, a
/// radian of a normal and the range of the texture grid each weigh as a fraction of the model's diagonal.
/// Computed normals do not count (the surface says it already), they only tell the sides of creases apart.
/// Source: Hoppe, New Quadric Metric for Simplifying Meshes with Appearance Attributes, 1999.
class WedgeQuadrics {
 public:
  /// Adds the triangles' planes to the positions' quadrics.
  /// @param diagonal  of the model, in lattice steps
  /// @param weight    of attributes beside positions; 1 as documented, 0 for none
  WedgeQuadrics(CollapseMesh& mesh, double diagonal, double weight);

  /// Nothing in the mesh's attributes that counts.
  bool empty() const noexcept { return channels_.empty(); }
  /// Every attribute that would be mixed counts: setValues() leaves nothing of what a wedge had.
  bool coversAll() const noexcept { return covers_all_; }
  void fetch(uint32_t wedge) const noexcept;

  /// Takes from a position's quadric what the best attributes of a wedge, or of two that are one, make up
  /// for.
  void reduce(Quadric& q, uint32_t wedge) const noexcept;
  void reduce(Quadric& q, uint32_t wedge, uint32_t other) const noexcept;
  void join(uint32_t keep, uint32_t gone) noexcept;
  /// Gives a wedge its best attributes at a place.
  void setValues(WedgeTable& wedges, uint32_t wedge, glm::dvec3 point) const;

 private:
  struct Channel {
    int part;      // of WedgeValue
    double scale;  // lattice steps a unit
  };
  struct Sum {
    glm::dvec3 g{0};
    double d = 0;
  };
  void chooseChannels(AttributeSet attributes, double diagonal, double weight);
  void addTriangle(CollapseMesh& mesh, uint32_t corner);

  std::vector<Channel> channels_;
  bool covers_all_ = false;
  std::vector<double> lengths_;  // channels_.size() a wedge, while triangles are added
  std::vector<double> areas_;    // a wedge
  std::vector<Sum> sums_;        // channels_.size() a wedge
};

}  // namespace lode::ingest
