#include "server/ingest/preview/clustered_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "server/ingest/mesh/number_table.h"
#include "server/ingest/preview/cell_sums.h"
#include "server/ingest/preview/face_triangles.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNone = UINT32_MAX;

/// Sorts the corners so that the smallest comes first, and keeps the orientation.
glm::u32vec3 rotated(glm::u32vec3 t) noexcept {
  while (t.x > t.y || t.x > t.z) t = {t.y, t.z, t.x};
  return t;
}

uint64_t edgeKey(uint32_t a, uint32_t b) noexcept { return uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

/// Triangles with corners in three cells, without duplicates. The indices are those of the cells.
class CellTriangles {
 public:
  void add(glm::u32vec3 cells) {
    triangles_.push_back(rotated(cells));
    if (triangles_.size() >= next_check_) removeDuplicates();
  }
  void removeDuplicates() {
    std::ranges::sort(triangles_, {}, [](glm::u32vec3 t) { return std::tuple(t.x, t.y, t.z); });
    triangles_.erase(std::unique(triangles_.begin(), triangles_.end()), triangles_.end());
    unique_ = triangles_.size();
    next_check_ = std::max<size_t>(kFirstCheck, 2 * unique_);
  }
  /// Returns the number of triangles after the last removal of duplicates.
  size_t uniqueCount() const noexcept { return unique_; }
  const std::vector<glm::u32vec3>& all() const noexcept { return triangles_; }

 private:
  static constexpr size_t kFirstCheck = 1 << 19;
  std::vector<glm::u32vec3> triangles_;
  size_t next_check_ = kFirstCheck, unique_ = 0;
};

/// For each pair of cells and each single cell, the first triangle whose corners lie only there.
class FlatTriangles {
 public:
  struct Flat {
    uint32_t a, b;          ///< the cells; equal if all corners are in one cell
    glm::u32vec3 vertices;  ///< vertices of the input
  };
  explicit FlatTriangles(uint32_t cells) : of_cell_(cells, glm::u32vec3(kNone)) { numbers_.reset(cells); }

  void addInCell(uint32_t cell, glm::u32vec3 vertices) {
    if (of_cell_[cell].x == kNone) of_cell_[cell] = vertices;
  }
  void addBetween(uint32_t a, uint32_t b, glm::u32vec3 vertices) {
    const auto number = static_cast<uint32_t>(between_.size());
    if (numbers_.findOrAdd(edgeKey(a, b), number) == number) between_.push_back({a, b, vertices});
  }
  size_t countBetween() const noexcept { return between_.size(); }

  /// Returns the triangles that no triangle between three cells covers.
  std::vector<Flat> uncovered(const std::vector<glm::u32vec3>& triangles) const {
    NumberTable edges;
    edges.reset(triangles.size() * 2);
    std::vector<bool> is_used(of_cell_.size());
    for (const glm::u32vec3& t : triangles)
      for (int k = 0; k < 3; ++k) {
        edges.findOrAdd(edgeKey(t[k], t[(k + 1) % 3]), 0);
        is_used[t[k]] = true;
      }
    std::vector<Flat> left;
    for (const Flat& flat : between_)
      if (edges.findOrAdd(edgeKey(flat.a, flat.b), 1) == 1) {
        left.push_back(flat);
        is_used[flat.a] = is_used[flat.b] = true;
      }
    for (uint32_t cell = 0; cell < of_cell_.size(); ++cell)
      if (!is_used[cell] && of_cell_[cell].x != kNone) left.push_back({cell, cell, of_cell_[cell]});
    return left;
  }

 private:
  std::vector<glm::u32vec3> of_cell_;
  NumberTable numbers_;
  std::vector<Flat> between_;
};

/// Triangles of the input, sorted by the number of cells that they touch.
struct SortedTriangles {
  CellTriangles of_three;
  FlatTriangles flat;
};

/// Sorts all triangles, and adds them to the sums of their cells.
/// @return nothing if the limit of triangles is exceeded.
std::optional<SortedTriangles> sortTriangles(const PackedInput& input, const ClusterGrid& grid,
                                             CellSums& sums, uint32_t max_triangles) {
  SortedTriangles sorted{{}, FlatTriangles(grid.cellCount())};
  PackedInput::FaceCursor cursor(input);
  PackedInput::FaceBlock block;
  while (cursor.next(block)) {
    forEachTriangle(block, grid, [&](glm::u32vec3 vertices, const TrianglePlace& place) {
      const glm::u32vec3 cells(grid.cellOf(vertices.x), grid.cellOf(vertices.y), grid.cellOf(vertices.z));
      if (grid.coincide(vertices)) return;
      sums.addTriangle(grid, vertices, cells, block, place);
      if (cells.x == cells.y && cells.y == cells.z)
        sorted.flat.addInCell(cells.x, vertices);
      else if (cells.x == cells.y || cells.y == cells.z || cells.z == cells.x)
        sorted.flat.addBetween(cells.x, cells.x == cells.y ? cells.z : cells.y, vertices);
      else
        sorted.of_three.add(cells);
    });
    if (sorted.of_three.uniqueCount() > max_triangles || sorted.flat.countBetween() > max_triangles)
      return std::nullopt;
  }
  sorted.of_three.removeDuplicates();
  return sorted;
}

/// Builds a mesh from cells and from vertices of the input.
class MeshAssembly {
 public:
  MeshAssembly(const ClusterGrid& grid, const CellSums& sums)
      : grid_(grid), sums_(sums), vertex_of_cell_(grid.cellCount(), kNone) {
    mesh_.attributes = sums.attributes();
  }

  void add(glm::u32vec3 cells) {
    glm::u32vec3 triangle;
    for (int k = 0; k < 3; ++k) {
      uint32_t& vertex = vertex_of_cell_[cells[k]];
      if (vertex == kNone) vertex = addVertex(sums_.pointOf(grid_, cells[k]), cells[k]);
      triangle[k] = vertex;
    }
    mesh_.triangles.push_back(triangle);
  }
  void addFlat(glm::u32vec3 vertices) {
    glm::u32vec3 triangle;
    for (int k = 0; k < 3; ++k)
      triangle[k] = addVertex(grid_.positionOf(vertices[k]), grid_.cellOf(vertices[k]));
    mesh_.triangles.push_back(triangle);
  }
  Mesh take() { return std::move(mesh_); }

 private:
  uint32_t addVertex(glm::uvec3 position, uint32_t cell) {
    mesh_.positions.push_back(packPosition(position));
    mesh_.vertex_attributes.push_back(sums_.attributesOf(cell));
    return static_cast<uint32_t>(mesh_.positions.size() - 1);
  }

  const ClusterGrid& grid_;
  const CellSums& sums_;
  std::vector<uint32_t> vertex_of_cell_;
  Mesh mesh_;
};

}  // namespace

double ClusteredMesh::errorSteps() const noexcept { return std::sqrt(3.0) * cell_steps; }

ClusteredMesh clusterInput(const PackedInput& input, const Lattice& lattice, glm::uvec3 extent,
                           const TextureColours& textures, const ClusterLimits& limits) {
  ClusterGrid grid(input, lattice, extent, limits.cells);
  for (;; grid.coarsen()) {
    CellSums sums(input, grid, textures);
    const std::optional<SortedTriangles> sorted = sortTriangles(input, grid, sums, limits.triangles);
    if (!sorted) continue;
    const std::vector<FlatTriangles::Flat> flat = sorted->flat.uncovered(sorted->of_three.all());
    if (sorted->of_three.all().size() + flat.size() > limits.triangles) continue;
    MeshAssembly mesh(grid, sums);
    for (const glm::u32vec3& cells : sorted->of_three.all()) mesh.add(cells);
    for (const FlatTriangles::Flat& triangle : flat) mesh.addFlat(triangle.vertices);
    return {mesh.take(), grid.widthSteps()};
  }
}

}  // namespace lode::ingest
