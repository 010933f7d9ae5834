#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// Ends of the open edges of a file, each place once.
struct OpenBorder {
  std::vector<glm::dvec3> places;
  double edge_model = 0;  ///< mean length of the open edges
};

/// Gap between the borders of two neighbouring files of a model.
struct BorderGap {
  size_t first = 0, second = 0;  ///< indices of the files
  /// Number of places on both borders that have a place of the other border within reach.
  uint64_t places = 0;
  uint64_t apart = 0;  ///< number of these places that do not coincide with a place of the other border
  double farthest_model = 0;  ///< largest distance of these places from the nearest place of the other border
};

/// Compares the borders of all pairs of files. Places within half of the longer mean edge of both borders are
/// within reach. Returns pairs that have places within reach, in ascending order.
std::vector<BorderGap> compareBorders(std::span<const OpenBorder> borders);

}  // namespace lode::ingest
