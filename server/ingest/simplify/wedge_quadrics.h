#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/quadric.h"

namespace lode::ingest {

/// Quadrics over position and attributes. A triangle defines the value of each attribute at any point p:
/// dot(g, p) + d, with g in the triangle's plane. A vertex at p with the value s has the error area * (dot(g,
/// p) + d - s)^2. The terms without s have the form of a plane's error and are added to the position's
/// Quadric. For the terms with s, each wedge (one set of attributes at a position) stores three sums over its
/// triangles: W = sum of area, G = sum of area * g, D = sum of area * d. The best value at p is s = (dot(G,
/// p) + D) / W. With this value the error depends on p alone: Q(p) - (dot(G, p) + D)^2 / W, with one such
/// term per attribute.
///
/// The file's normals, colours and texture coordinates are scaled to lengths. One radian between normals, the
/// full range of a colour and the full range of the texture grid each correspond to a fraction of the model's
/// diagonal. Computed normals add no error, because they follow from the surface; they only separate the
/// sides of creases.
/// Source: Hoppe, New Quadric Metric for Simplifying Meshes with Appearance Attributes, 1999.
class WedgeQuadrics {
 public:
  /// Adds the terms without s of all triangles to the positions' quadrics, and sums the other terms per
  /// wedge.
  /// @param diagonal  the model's diagonal, in lattice steps
  /// @param weight  weight of attributes relative to geometry; 1 by default; 0 ignores attributes
  WedgeQuadrics(CollapseMesh& mesh, double diagonal, double weight);

  /// Returns true if the mesh has no attributes that add errors.
  bool empty() const noexcept { return channels_.empty(); }
  /// Returns true if setValues() sets all attributes of a wedge, so that a merge need not mix them.
  bool coversAll() const noexcept { return covers_all_; }
  void prefetch(uint32_t wedge) const noexcept;

  /// Subtracts from a position's quadric the error that vanishes if the wedge has the best attributes.
  void reduce(Quadric& q, uint32_t wedge) const noexcept;
  /// Like reduce() above, for the wedge that would result from joining two wedges.
  void reduce(Quadric& q, uint32_t wedge, uint32_t other) const noexcept;
  /// Adds the areas and sums of `gone` to those of `keep`.
  void join(uint32_t keep, uint32_t gone) noexcept;
  /// Sets a wedge's attributes to the best attributes at a point.
  void setValues(WedgeTable& wedges, uint32_t wedge, glm::dvec3 point) const;

 private:
  struct Channel {
    int part;      // index in WedgeValue::parts
    double scale;  // lattice steps per unit
  };
  struct Sum {
    glm::dvec3 g{0};
    double d = 0;
  };
  void chooseChannels(AttributeSet attributes, double diagonal, double weight);
  void addTriangle(CollapseMesh& mesh, uint32_t corner);

  std::vector<Channel> channels_;
  bool covers_all_ = false;
  std::vector<double> lengths_;  // channels_.size() values per wedge; used only while triangles are added
  std::vector<double> areas_;    // total area of the triangles of each wedge
  std::vector<Sum> sums_;        // channels_.size() sums per wedge
};

}  // namespace lode::ingest
