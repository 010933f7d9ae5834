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

/// Returns the measured value; nothing while points are missing. The error bound follows from uncertaintyOf()
/// of each point. A distance is between two points, a polyline goes through all points, and an angle is at
/// the second of three points. An area is the length of the polygon's vector area. A height is that of the
/// second point above the first. Pure.
/// @param up  up axis, unit length.
std::optional<MeasuredValue> valueOf(const Measure& measure, const glm::dvec3& up);

/// Formats the value with its uncertainty and unit; empty if valueOf() returns nothing. Shows two significant
/// digits of the uncertainty, but no more decimals than the lattice resolves. Pure.
std::string valueText(const Measure& measure, const glm::dvec3& up, std::string_view unit);

/// Returns the measurements as comma-separated values: a heading, then a line per measurement. Pure.
std::string measuresAsCsv(const std::vector<Measure>& measures, const glm::dvec3& up, std::string_view unit);
/// Returns the measurements as one JSON object. Pure.
std::string measuresAsJson(const std::vector<Measure>& measures, const glm::dvec3& up, std::string_view unit);

}  // namespace lode::app
