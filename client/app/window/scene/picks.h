#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/app/window/scene/measure.h"
#include "client/app/window/scene/picked_point.h"

namespace lode::app {

/// The points that the user has clicked, as a measurement, and the measurements that the user has kept.
class Picks {
 public:
  /// Adds a point. Removes the oldest point if there are more than the kind of measurement allows.
  void add(PickedPoint point);
  /// Removes the points, but not the kept measurements.
  void clear() noexcept;
  /// Undoes the last pick. Used for a double click, because its first click has already picked a point.
  void takeBack() { current_.points = before_; }

  /// Switches to the next kind of measurement. Keeps the points that fit.
  void nextKind() noexcept;
  MeasureKind kind() const noexcept { return current_.kind; }
  /// Keeps the current measurement and begins another of the same kind. @return false if points are missing.
  bool keep();
  /// Removes the measurement that was kept last. @return false if there is none.
  bool dropLast() noexcept;
  /// Returns true if measurements were kept, or one of them removed, since the last markSaved().
  bool hasUnsaved() const noexcept { return is_unsaved_ && !kept_.empty(); }
  void markSaved() noexcept { is_unsaved_ = false; }
  /// Returns the kept measurements, and then the current one if it has all points.
  std::vector<Measure> all() const;
  /// Returns the kept measurements, and then the current one. snap() changes their points.
  std::vector<Measure*> measures();

  /// Returns lines of text about the last point: coordinates, node, LOD, error and colour; then a line for
  /// the current measurement, and for each kept one. @param up  up axis. @param unit  unit of length; may be
  /// empty.
  std::vector<std::string> lines(const glm::dvec3& up, std::string_view unit) const;
  const Measure& current() const noexcept { return current_; }
  const std::vector<Measure>& kept() const noexcept { return kept_; }

 private:
  Measure current_;
  std::vector<PickedPoint> before_;
  std::vector<Measure> kept_;
  bool is_unsaved_ = false;
};

}  // namespace lode::app
