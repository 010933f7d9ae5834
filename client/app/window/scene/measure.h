#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/window/scene/picked_point.h"

namespace lode::app {

enum class MeasureKind : uint8_t { kDistance, kPolyline, kAngle, kArea, kHeight };
constexpr size_t kMeasureKindCount = 5;

/// A measurement by points that the user has picked.
struct Measure {
  MeasureKind kind = MeasureKind::kDistance;
  std::vector<PickedPoint> points;
};

/// A measured value and a bound of its error.
struct MeasuredValue {
  double value = 0, off = 0;
  int power = 1;  ///< power of the unit of length: 1 or 2; 0: degrees
};

/// Returns the name of a kind: "distance", "polyline", "angle", "area" or "height".
std::string_view nameOf(MeasureKind kind) noexcept;
/// Returns the largest number of points of a kind.
size_t mostPoints(MeasureKind kind) noexcept;

/// Measures; nothing while points are missing. The bound follows from uncertaintyOf() of the points. A
/// distance is between two points, a polyline goes through all points, an angle is at the second of three
/// points, an area is that of the polygon's vector area, and a height is the second point's height above the
/// first. Pure.
/// @param up  up axis, unit length.
std::optional<MeasuredValue> valueOf(const Measure& measure, const glm::dvec3& up);

/// Returns the value with its uncertainty and unit; empty if valueOf() has none. Has two significant digits
/// of the uncertainty, but no more decimals than the lattice resolves. Pure.
std::string valueText(const Measure& measure, const glm::dvec3& up, std::string_view unit);

/// Returns the measurements as a table of comma-separated values with a heading, a line each. Pure.
std::string measuresAsCsv(const std::vector<Measure>& measures, const glm::dvec3& up, std::string_view unit);
/// Returns the measurements as one JSON object. Pure.
std::string measuresAsJson(const std::vector<Measure>& measures, const glm::dvec3& up, std::string_view unit);

}  // namespace lode::app
