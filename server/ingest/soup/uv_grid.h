#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Range of texture coordinates.
struct UvRange {
  glm::dvec2 min{std::numeric_limits<double>::infinity()};
  glm::dvec2 max{-std::numeric_limits<double>::infinity()};

  void add(glm::vec2 uv) noexcept {
    min = glm::min(min, glm::dvec2(uv));
    max = glm::max(max, glm::dvec2(uv));
  }
  bool empty() const noexcept { return !(min.x <= max.x); }
  /// Returns true if the range lies within 0..1 or is empty.
  bool withinImage() const noexcept {
    return empty() || (glm::all(glm::greaterThanEqual(min, glm::dvec2(0))) &&
                       glm::all(glm::lessThanEqual(max, glm::dvec2(1))));
  }
};

/// Grid of a model's texture coordinates: origin + code * 2^(scale_exponent - 16). See TextureSet.
struct UvGrid {
  glm::dvec2 origin{0};
  int32_t scale_exponent = 0;

  bool operator==(const UvGrid&) const = default;
  /// Returns the nearest code, clamped to the grid.
  glm::u16vec2 snap(glm::vec2 uv) const noexcept;
};

/// Chooses the finest grid that covers a range, with a step of at least 2^-16. The origin is 0 if the range
/// is within 0..1. The largest coordinate can be up to one step beyond the last code.
/// @param file  name of the file for the error message.
/// @throws Error kInput if the range is too wide for any grid.
UvGrid chooseUvGrid(const UvRange& range, const std::string& file);

}  // namespace lode::ingest
