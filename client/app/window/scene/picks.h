#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/core/lod/cut_probe.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// A surface point at a pixel.
struct PickedPoint {
  glm::dvec3 position_model;  ///< in the frame of ViewedScene::summary()
  glm::dvec3 position;        ///< true coordinates
  bool is_ground = false;     ///< on a scene's ground: has no node, LOD and error
  NodeKey node;
  uint32_t lod = 0;
  float error_px = 0;
  double step = 1;  ///< lattice step: the precision of the position
  std::optional<glm::u8vec3> colour;
  std::string model;  ///< name; empty on the ground and in a scene of a single model
};

/// Describes a hit. @param textured  see core::paintAt().
PickedPoint pointOf(const core::Hit& hit, const ModelSummary& model, const core::Cut& textured);

/// The last two points that the user clicked on, as text.
class Picks {
 public:
  void add(PickedPoint point);
  void clear() noexcept;
  /// Undoes the last change: a double click begins with a click.
  void takeBack() { picks_ = before_; }

  /// Describes the last point: coordinates, node, LOD, error, colour, and the distance to the point before.
  /// Empty if there is none.
  std::vector<std::string> lines() const;
  /// Distance between the two points; empty if there are not two.
  std::string distance() const;
  std::span<const PickedPoint> points() const noexcept { return picks_; }

 private:
  std::vector<PickedPoint> picks_, before_;
};

}  // namespace lode::app
