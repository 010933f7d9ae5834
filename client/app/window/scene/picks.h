#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/core/lod/cut_probe.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// A surface point that the user has picked in the picture. Lengths are in the units of the scene's file.
struct PickedPoint {
  glm::dvec3 position_model;  ///< position in the frame of ViewedScene::summary()
  glm::dvec3 position;        ///< position in the coordinates of the model's or the scene's file
  bool is_ground = false;     ///< the point is on the scene's ground, which has no node, LOD or error
  NodeKey node;
  uint32_t lod = 0;
  float error_px = 0;
  double step = 1;  ///< lattice step, which limits the precision of the position
  std::optional<glm::u8vec3> colour;
  std::string model;  ///< name of the model; empty on the ground and in a scene of one model
  double error = 0;   ///< bound of the distance from the position to the original surface
  size_t model_number = 0, instance = 0;  ///< index in Scene::models, and of the model's instance
  core::Ray seen_along;                   ///< ray of the click, in the frame of position_model
  glm::dvec3 normal{0};                   ///< normal of the picked triangle in this frame, unit length
};

/// Returns the picked point of a ray's hit. @param textured  cut that has the model's textures; see
/// paintAt().
PickedPoint pointOf(const core::Hit& hit, const ModelSummary& model, const core::Cut& textured);

/// Returns a bound of the distance from a pick to the point that a click on the original surface would give:
/// the point's error, and half of the diagonal of a lattice cell. Pure.
double uncertaintyOf(const PickedPoint& point) noexcept;

/// The last two points that the user has clicked.
class Picks {
 public:
  void add(PickedPoint point);
  void clear() noexcept;
  /// Undoes the last pick. Used for a double click, because its first click has already picked a point.
  void takeBack() { picks_ = before_; }

  /// Replaces a point by the point of a finer surface. @param number  index in points().
  void snap(size_t number, PickedPoint point) { picks_[number] = std::move(point); }

  /// Returns lines of text about the last point: coordinates, node, LOD, error, colour, and the distance to
  /// the previous point. Returns no lines if no point is picked. @param unit  unit of length; may be empty.
  std::vector<std::string> lines(std::string_view unit) const;
  /// Returns the distance between the two points, with the uncertainty of both, as text; empty if fewer than
  /// two points are picked.
  std::string distance(std::string_view unit) const;
  std::span<const PickedPoint> points() const noexcept { return picks_; }

 private:
  std::vector<PickedPoint> picks_, before_;
};

}  // namespace lode::app
