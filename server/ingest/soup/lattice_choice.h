#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/lattice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Step of a model's lattice: the largest of isLatticeStep() that is at most 1/32 of the 5th-percentile edge
/// and 1/4096 of the longest side of the box, but coarse enough that the box fits 21 bits and that double
/// holds the coordinates. See docs/store-format.md.
/// @param edges  lengths of a sample of edges, true units; zero lengths are left out; changed (partly
/// sorted).
double chooseStep(std::vector<double>& edges, glm::dvec3 box_min, glm::dvec3 box_max);

/// A face that is looked at: its first corners, at most four; the fourth of a triangle is its first.
using SampledFace = std::array<uint32_t, 4>;
SampledFace sampledFace(std::span<const uint32_t> corners);
/// Every how manieth face is looked at: all of the first quarter of a million.
uint64_t faceStride(uint64_t faces) noexcept;

/// The place of a vertex, in true units.
using PositionOf = std::function<glm::dvec3(uint32_t vertex)>;

/// Whether the lattice makes neighbouring corners of a face one that the file has apart. (A face that has
/// corners in one place in the file is flat, not lost.)
bool isLost(std::span<const uint32_t> corners, const PositionOf& position_of, const Lattice& lattice);

/// The step above, made finer by halves until no more than a millionth of the faces that are looked at is
/// lost, or until finer ones keep no more of them. The origin is a multiple of it.
Lattice chooseLattice(std::span<const SampledFace> faces, const PositionOf& position_of, glm::dvec3 box_min,
                      glm::dvec3 box_max);

/// Vertices that faces use (a stray one must not cost precision), as far as a lattice follows from them.
struct UsedVertices {
  uint64_t count = 0;
  glm::dvec3 min{std::numeric_limits<double>::max()}, max{std::numeric_limits<double>::lowest()};  ///< box
  std::vector<SampledFace> faces;     ///< that are looked at; their corners are numbers of `positions`
  std::vector<glm::dvec3> positions;  ///< of those corners
  bool coincide() const noexcept { return !glm::any(glm::lessThan(min, max)); }
};
UsedVertices findUsedVertices(const PackedInput& input);

/// The lattice of vertices, or why there is none and what to do.
struct LatticeOrProblem {
  std::optional<Lattice> lattice;
  std::string_view problem;
};
LatticeOrProblem chooseLattice(const UsedVertices& used);

struct LatticeChoice {
  Lattice lattice;
  glm::uvec3 extent{0};       ///< largest lattice coordinates of the referenced vertices
  glm::dvec3 min{0}, max{0};  ///< their box, as the file has it
};

/// The second look: from findUsedVertices().
/// @throws Error kInput if there is no lattice.
LatticeChoice chooseLattice(const PackedInput& input, const std::filesystem::path& name);

}  // namespace lode::ingest
