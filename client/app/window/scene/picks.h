#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/core/lod/cut_probe.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// A point of a picture.
struct PickedPoint {
  glm::dvec3 position_model;  ///< in the frame of what is looked at
  glm::dvec3 position;        ///< true coordinates
  bool is_ground = false;     ///< of a scene: it has no node, LOD and error
  NodeKey node;
  uint32_t lod = 0;
  float error_px = 0;
  double step = 1;  ///< of the lattice
  std::optional<glm::u8vec3> colour;
  std::string model;  ///< whose point it is, where there are several
};

/// @param textured  see core::paintAt().
PickedPoint pointOf(const core::Hit& hit, const ModelSummary& model, const core::Cut& textured);

/// The last two points that were clicked on, as text.
class Picks {
 public:
  void add(PickedPoint point);
  void clear() noexcept;
  /// The last of these was not meant: a double click begins with one.
  void takeBack() { picks_ = before_; }

  /// Of the last point: coordinates, node, LOD, error, colour; and how far it is from the one before.
  /// Empty without one.
  std::vector<std::string> lines() const;
  /// Between the last two points, as text; empty where there are not two.
  std::string distance() const;
  std::span<const PickedPoint> points() const noexcept { return picks_; }

 private:
  std::vector<PickedPoint> picks_, before_;
};

}  // namespace lode::app
