#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/quadric.h"

namespace lode::ingest {

/// Quadrics over position and attributes. For every attribute s each triangle defines a value at any point p:
/// dot(g, p) + d, with g in the triangle's plane; the error is area * (dot(g, p) + d - s)^2. The terms
/// without s are planes in the position's Quadric. The rest is stored per wedge: sums W, G and D of area,
/// area * g and area * d. For a given p the best s is (dot(G, p) + D) / W, which leaves a quadric in p alone:
/// Q(p) - sum (dot(G, p) + D)^2 / W.
///
/// The file's normals, colours and texture coordinates are scaled to lengths: one radian of a normal and the
/// full range of a colour or of the texture grid are each a fraction of the model's diagonal. Computed
/// normals follow from the surface and do not count; they only separate the sides of creases.
/// Source: Hoppe, New Quadric Metric for Simplifying Meshes with Appearance Attributes, 1999.
class WedgeQuadrics {
 public:
  /// Adds the attributes' planes of all triangles to the positions' quadrics.
  /// @param diagonal  of the model, in lattice steps
  /// @param weight    of attributes against geometry; 1: the default weights, 0: none
  WedgeQuadrics(CollapseMesh& mesh, double diagonal, double weight);

  /// True if the mesh has no attribute that counts.
  bool empty() const noexcept { return channels_.empty(); }
  /// True if setValues() sets every attribute that merging would otherwise mix.
  bool coversAll() const noexcept { return covers_all_; }
  void prefetch(uint32_t wedge) const noexcept;

  /// Subtracts from a position's quadric the part that the best attributes of a wedge, or of two merged
  /// wedges, explain.
  void reduce(Quadric& q, uint32_t wedge) const noexcept;
  void reduce(Quadric& q, uint32_t wedge, uint32_t other) const noexcept;
  void join(uint32_t keep, uint32_t gone) noexcept;
  /// Sets a wedge's attributes to the best ones at a point.
  void setValues(WedgeTable& wedges, uint32_t wedge, glm::dvec3 point) const;

 private:
  struct Channel {
    int part;      // index into WedgeValue::parts
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
  std::vector<double> lengths_;  // channels_.size() per wedge; only while triangles are added
  std::vector<double> areas_;    // by wedge
  std::vector<Sum> sums_;        // channels_.size() per wedge
};

}  // namespace lode::ingest
