#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <glm/glm.hpp>

namespace lode::ingest {

/// The texture coordinates that a file uses.
struct UvRange {
  glm::dvec2 min{std::numeric_limits<double>::infinity()};
  glm::dvec2 max{-std::numeric_limits<double>::infinity()};

  void add(glm::vec2 uv) noexcept {
    min = glm::min(min, glm::dvec2(uv));
    max = glm::max(max, glm::dvec2(uv));
  }
  bool empty() const noexcept { return !(min.x <= max.x); }
  /// Nothing of it lies outside 0 ... 1.
  bool withinImage() const noexcept {
    return empty() || (glm::all(glm::greaterThanEqual(min, glm::dvec2(0))) &&
                       glm::all(glm::lessThanEqual(max, glm::dvec2(1))));
  }
};

/// The grid of a model's texture coordinates, see TextureSet: origin + code * 2^(scale_exponent - 16).
struct UvGrid {
  glm::dvec2 origin{0};
  int32_t scale_exponent = 0;

  bool operator==(const UvGrid&) const = default;
  /// Nearest code; beyond the ends the last.
  glm::u16vec2 snap(glm::vec2 uv) const noexcept;
};

/// The finest grid that holds a range, of a step of 2^-16 at least; what lies within 0 ... 1 gets the origin
/// 0. The greatest coordinate may lie up to a step beyond the last code.
/// @param file  for the message.
/// @throws Error kInput if the range is too wide for any grid.
UvGrid chooseUvGrid(const UvRange& range, const std::string& file);

}  // namespace lode::ingest
