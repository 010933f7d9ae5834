#include "client/app/window/scene/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace lode::app {
namespace {

constexpr std::array<std::string_view, kMeasureKindCount> kNames{"distance", "polyline", "angle", "area",
                                                                 "height"};
constexpr size_t kMostPicks = 1000;  ///< limit of the points of a polyline or an area

MeasuredValue lengthOf(const std::vector<PickedPoint>& points) {
  MeasuredValue length;
  for (size_t i = 1; i < points.size(); ++i) {
    length.value += glm::distance(points[i - 1].position, points[i].position);
    length.off += uncertaintyOf(points[i - 1]) + uncertaintyOf(points[i]);
  }
  return length;
}

/// If the ends of a leg of length l are off by u and v, the leg turns by at most asin((u + v) / l).
MeasuredValue angleOf(const std::vector<PickedPoint>& points) {
  const PickedPoint& corner = points[1];
  MeasuredValue angle{.power = 0};
  std::array<glm::dvec3, 2> legs;
  for (size_t leg = 0; leg < 2; ++leg) {
    const PickedPoint& end = points[2 * leg];
    legs[leg] = end.position - corner.position;
    const double sine =
        (uncertaintyOf(end) + uncertaintyOf(corner)) / std::max(glm::length(legs[leg]), 1e-300);
    angle.off += sine < 1 ? glm::degrees(std::asin(sine)) : 180;
  }
  angle.off = std::min(angle.off, 180.0);
  angle.value =
      glm::degrees(std::atan2(glm::length(glm::cross(legs[0], legs[1])), glm::dot(legs[0], legs[1])));
  return angle;
}

/// The vector area is half the sum of the cross products of neighbouring corners p_i. If each corner is off
/// by at most u_i, the area is off by at most half the sum of u_i |p_(i+1) - p_(i-1)| + u_i u_(i+1).
MeasuredValue areaOf(const std::vector<PickedPoint>& points) {
  const size_t count = points.size();
  const glm::dvec3& origin = points.front().position;  // keeps the coordinates' precision
  glm::dvec3 area(0);
  MeasuredValue measured{.power = 2};
  for (size_t i = 0; i < count; ++i) {
    const PickedPoint &before = points[(i + count - 1) % count], &next = points[(i + 1) % count];
    area += glm::cross(points[i].position - origin, next.position - origin) / 2.0;
    measured.off +=
        uncertaintyOf(points[i]) * (glm::distance(next.position, before.position) + uncertaintyOf(next)) / 2;
  }
  measured.value = glm::length(area);
  return measured;
}

std::string unitOf(const MeasuredValue& value, std::string_view unit) {
  if (value.power == 0) return "deg";
  if (unit.empty()) return "";
  return std::string(unit) + (value.power == 2 ? "2" : "");
}

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

}  // namespace

std::string_view nameOf(MeasureKind kind) noexcept { return kNames[static_cast<size_t>(kind)]; }

size_t mostPoints(MeasureKind kind) noexcept {
  switch (kind) {
    case MeasureKind::kDistance:
    case MeasureKind::kHeight:
      return 2;
    case MeasureKind::kAngle:
      return 3;
    case MeasureKind::kPolyline:
    case MeasureKind::kArea:
      break;
  }
  return kMostPicks;
}

std::optional<MeasuredValue> valueOf(const Measure& measure, const glm::dvec3& up) {
  const std::vector<PickedPoint>& points = measure.points;
  const bool needs_three = measure.kind == MeasureKind::kAngle || measure.kind == MeasureKind::kArea;
  if (points.size() < (needs_three ? 3 : 2)) return std::nullopt;
  switch (measure.kind) {
    case MeasureKind::kAngle:
      return angleOf(points);
    case MeasureKind::kArea:
      return areaOf(points);
    case MeasureKind::kHeight: {
      MeasuredValue height = lengthOf(points);
      height.value = glm::dot(points[1].position - points[0].position, up);
      return height;
    }
    case MeasureKind::kDistance:
    case MeasureKind::kPolyline:
      break;
  }
  return lengthOf(points);
}

std::string valueText(const Measure& measure, const glm::dvec3& up, std::string_view unit) {
  const auto value = valueOf(measure, up);
  if (!value) return "";
  const int most = value->power == 1 ? decimalsOf(measure.points.back().step) : 12;
  const int decimals =
      std::min(most, std::clamp(1 - static_cast<int>(std::floor(std::log10(value->off))), 0, 12));
  char text[128];
  std::snprintf(text, sizeof text, "%.*f \u00b1 %.*f", decimals, value->value, decimals, value->off);
  const std::string its_unit = value->power == 0                    ? "\u00b0"
                               : value->power == 2 && !unit.empty() ? std::string(unit) + "\u00b2"
                                                                    : std::string(unit);
  return its_unit.empty() ? text : text + (" " + its_unit);
}

std::string measuresAsCsv(const std::vector<Measure>& measures, const glm::dvec3& up, std::string_view unit) {
  std::string table = "kind,value,uncertainty,unit,points\n";
  for (const Measure& measure : measures) {
    const auto value = valueOf(measure, up);
    if (!value) continue;
    table += std::string(nameOf(measure.kind)) + "," + numberText(value->value) + "," +
             numberText(value->off) + "," + unitOf(*value, unit) + ",";
    for (size_t i = 0; i < measure.points.size(); ++i) {
      const glm::dvec3& at = measure.points[i].position;
      table += (i > 0 ? ";" : "") + numberText(at.x) + " " + numberText(at.y) + " " + numberText(at.z);
    }
    table += "\n";
  }
  return table;
}

std::string measuresAsJson(const std::vector<Measure>& measures, const glm::dvec3& up,
                           std::string_view unit) {
  nlohmann::ordered_json json;
  json["up"] = {up.x, up.y, up.z};
  json["measurements"] = nlohmann::ordered_json::array();
  for (const Measure& measure : measures) {
    const auto value = valueOf(measure, up);
    if (!value) continue;
    nlohmann::ordered_json one;
    one["kind"] = nameOf(measure.kind);
    one["value"] = value->value;
    one["uncertainty"] = value->off;
    one["unit"] = unitOf(*value, unit);
    for (const PickedPoint& point : measure.points) {
      nlohmann::ordered_json at{{"position", {point.position.x, point.position.y, point.position.z}},
                                {"uncertainty", uncertaintyOf(point)}};
      if (!point.model.empty()) at["model"] = point.model;
      one["points"].push_back(std::move(at));
    }
    json["measurements"].push_back(std::move(one));
  }
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace lode::app
