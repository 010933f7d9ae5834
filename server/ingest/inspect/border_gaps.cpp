#include "server/ingest/inspect/border_gaps.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <unordered_map>

#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

/// Finds the nearest of many places within a given reach, by a grid of cells as large as the reach.
class NearestPlace {
 public:
  NearestPlace(std::span<const glm::dvec3> places, double reach) : places_(places), reach_(reach) {
    for (size_t i = 0; i < places.size(); ++i) cells_.emplace(keyOf(cellOf(places[i])), i);
  }

  /// Returns the distance to the nearest place, or nothing if none is within reach.
  std::optional<double> distance(glm::dvec3 from) const {
    const glm::dvec3 cell = cellOf(from);
    double least = std::numeric_limits<double>::max();
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto [begin, end] = cells_.equal_range(keyOf(cell + glm::dvec3(x, y, z)));
          for (auto at = begin; at != end; ++at)
            least = std::min(least, glm::distance(from, places_[at->second]));
        }
    return least <= reach_ ? std::optional(least) : std::nullopt;
  }

 private:
  glm::dvec3 cellOf(glm::dvec3 place) const { return glm::floor(place / reach_); }
  static uint64_t keyOf(glm::dvec3 cell) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key = NumberTable::hash(key * 31 + static_cast<uint64_t>(static_cast<int64_t>(cell[axis])));
    return key;
  }

  const std::span<const glm::dvec3> places_;
  const double reach_;
  std::unordered_multimap<uint64_t, size_t> cells_;
};

struct Box {
  glm::dvec3 min{std::numeric_limits<double>::max()}, max{std::numeric_limits<double>::lowest()};

  void add(glm::dvec3 place) {
    min = glm::min(min, place);
    max = glm::max(max, place);
  }
  bool isWithin(double reach, const Box& other) const {
    return glm::all(glm::lessThanEqual(min - reach, other.max)) &&
           glm::all(glm::lessThanEqual(other.min - reach, max));
  }
};

void addPlaces(std::span<const glm::dvec3> places, const NearestPlace& others, BorderGap& gap) {
  for (const glm::dvec3& place : places) {
    const std::optional<double> distance = others.distance(place);
    if (!distance) continue;
    ++gap.places;
    gap.apart += *distance > 0;
    gap.farthest_model = std::max(gap.farthest_model, *distance);
  }
}

}  // namespace

std::vector<BorderGap> compareBorders(std::span<const OpenBorder> borders) {
  std::vector<Box> boxes(borders.size());
  for (size_t i = 0; i < borders.size(); ++i)
    for (const glm::dvec3& place : borders[i].places) boxes[i].add(place);
  std::vector<BorderGap> gaps;
  for (size_t i = 0; i < borders.size(); ++i)
    for (size_t k = i + 1; k < borders.size(); ++k) {
      const OpenBorder &first = borders[i], &second = borders[k];
      const double reach = std::max(first.edge_model, second.edge_model) / 2;
      if (!(reach > 0) || !boxes[i].isWithin(reach, boxes[k])) continue;
      BorderGap gap{.first = i, .second = k};
      addPlaces(first.places, NearestPlace(second.places, reach), gap);
      if (gap.places > 0) addPlaces(second.places, NearestPlace(first.places, reach), gap);
      if (gap.places > 0) gaps.push_back(gap);
    }
  return gaps;
}

}  // namespace lode::ingest
