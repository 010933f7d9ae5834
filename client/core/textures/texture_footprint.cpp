#include "client/core/textures/texture_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace lode::core {
namespace {

using Corners = std::array<glm::dvec2, 3>;
using ModelCorners = std::array<glm::dvec3, 3>;

/// Limits two ratios: the density of a triangle is at least 1/8 of the density along its densest direction,
/// and the density of a tile at least 1/8 of the mean density. Equals the largest number of samples of the
/// shader's anisotropic filter: kMostTaps in client/render/passes/mesh_shaders.cpp.
constexpr double kMostStretch = 8;

/// Collects the level 0 tiles of one texture that a mesh uses.
class TouchedGrid {
 public:
  explicit TouchedGrid(const Texture& texture)
      : size_(levelSize(texture, 0)),
        across_(tilesAcross(texture, 0)),
        down_(tilesDown(texture, 0)),
        cells_(size_t{across_} * down_) {}

  /// @param corners  texture positions in texels from the image's top left corner, not wrapped.
  /// @param model  the triangle's corners in model units.
  void add(const Corners& corners, const ModelCorners& model, uint64_t& tests_left) {
    const Worn worn = wornBy(corners, model);
    const glm::dvec2 least = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec2 most = glm::max(corners[0], glm::max(corners[1], corners[2]));
    if (!all_) {
      const glm::dvec2 first = glm::floor(least / size_), last = lastBefore(most / size_, first);
      // Beyond this number of repetitions of the image, float coordinates have no precision left.
      constexpr double kMaxRepeats = 1 << 20;
      const bool in_range = glm::all(glm::lessThan(glm::abs(first), glm::dvec2(kMaxRepeats))) &&
                            glm::all(glm::lessThan(glm::abs(last), glm::dvec2(kMaxRepeats)));
      if (!in_range || glm::any(glm::greaterThan(most - least, size_))) {
        all_ = true;
      } else {
        for (double row = first.y; row <= last.y; ++row)
          for (double column = first.x; column <= last.x; ++column)
            addToImage(corners, worn, glm::dvec2(column, row) * size_, tests_left);
      }
    }
    note(whole_, worn);
  }

  bool isWhole() const noexcept { return all_; }
  void makeWhole() noexcept { all_ = true; }
  uint64_t touchedTiles() const noexcept {
    return static_cast<uint64_t>(
        std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.touched; }));
  }

  void appendTo(TextureFootprint& out, uint32_t texture) const {
    if (all_) {
      out.whole.push_back({texture, density(whole_)});
      return;
    }
    for (uint32_t y = 0; y < down_; ++y)
      for (uint32_t x = 0; x < across_; ++x) {
        const Cell& cell = cells_[size_t{y} * across_ + x];
        if (cell.touched) out.tiles.push_back({texture, y, x, density(cell.model_area > 0 ? cell : whole_)});
      }
  }

 private:
  /// Areas of a triangle on the model and in texels, and its texel density. All values are zero if the
  /// triangle has no area or if its corners share one texture position.
  struct Worn {
    double model_area = 0, texel_area = 0;
    double texels_per_model = 0;  ///< density along the direction with the fewest texels
  };
  struct Cell {
    double model_area = 0, texel_area = 0;
    double spread = 0;  ///< sum over triangles of area / (texels per model unit)²
    bool touched = false;
  };

  static Worn wornBy(const Corners& texels, const ModelCorners& model) {
    const glm::dvec3 ab = model[1] - model[0], ac = model[2] - model[0];
    const double length = glm::length(ab), doubled_area = glm::length(glm::cross(ab, ac));
    if (!(doubled_area > 0)) return {};
    // Texels per model unit along ab and perpendicular to it: the columns of a matrix whose singular values
    // are the largest and smallest density over all directions.
    const glm::dvec2 along = (texels[1] - texels[0]) / length;
    const glm::dvec2 across =
        (texels[2] - texels[0] - along * (glm::dot(ab, ac) / length)) * (length / doubled_area);
    const double squares = glm::dot(along, along) + glm::dot(across, across);
    const double product = std::abs(cross(along, across));
    const double most =
        std::sqrt((squares + std::sqrt(std::max(0.0, squares * squares - 4 * product * product))) / 2);
    if (!(most > 0)) return {};
    return {doubled_area / 2, product * doubled_area / 2, std::max(product / most, most / kMostStretch)};
  }

  // Returns the density of a cell: at least 1/8 of the mean density, so that a few degenerate triangles do
  // not dominate.
  static float density(const Cell& cell) {
    if (!(cell.model_area > 0)) return 0;
    const double leaning = std::sqrt(cell.model_area / cell.spread);
    const double mean = std::sqrt(cell.texel_area / cell.model_area);
    return static_cast<float>(std::min(std::max(leaning, mean / kMostStretch), 1e30));
  }

  static void note(Cell& cell, const Worn& worn) {
    if (worn.model_area == 0) return;
    cell.model_area += worn.model_area;
    cell.texel_area += worn.texel_area;
    cell.spread += worn.model_area / (worn.texels_per_model * worn.texels_per_model);
  }

  /// Returns, along each axis, the index of the last unit interval that contains values below `most`, but at
  /// least `first`.
  static glm::dvec2 lastBefore(glm::dvec2 most, glm::dvec2 first) {
    return glm::max(glm::ceil(most) - 1.0, first);
  }

  static double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

  /// Tests whether a triangle and a box overlap, by separating axes. Requires that their bounding boxes
  /// overlap.
  static bool overlaps(const Corners& corners, glm::dvec2 least, glm::dvec2 most) {
    const glm::dvec2 centre = (least + most) / 2.0, half = (most - least) / 2.0;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec2 edge = corners[(i + 1) % 3] - corners[i];
      const glm::dvec2 normal(-edge.y, edge.x);
      const double reach = glm::dot(glm::abs(normal), half);
      const double a = glm::dot(normal, corners[i] - centre);
      const double b = glm::dot(normal, corners[(i + 2) % 3] - centre);
      if (std::min(a, b) > reach || std::max(a, b) < -reach) return false;
    }
    return true;
  }

  /// Marks the tiles that a triangle touches in one repetition of the image.
  void addToImage(const Corners& corners, const Worn& worn, glm::dvec2 image_origin, uint64_t& tests_left) {
    Corners here;
    for (int i = 0; i < 3; ++i) here[i] = corners[i] - image_origin;
    const glm::dvec2 least = glm::max(glm::min(here[0], glm::min(here[1], here[2])), glm::dvec2(0));
    const glm::dvec2 most = glm::min(glm::max(here[0], glm::max(here[1], here[2])), size_);
    const glm::uvec2 end = glm::uvec2(across_, down_) - 1u;
    const glm::uvec2 first = glm::min(glm::uvec2(least / double{kTileInnerPx}), end);
    const glm::uvec2 last = glm::min(glm::uvec2(lastBefore(most / double{kTileInnerPx}, first)), end);
    for (uint32_t y = first.y; y <= last.y; ++y)
      for (uint32_t x = first.x; x <= last.x; ++x) {
        if (tests_left == 0) {
          all_ = true;
          return;
        }
        --tests_left;
        const glm::dvec2 corner = glm::dvec2(x, y) * double{kTileInnerPx};
        if (!overlaps(here, corner, glm::min(corner + double{kTileInnerPx}, size_))) continue;
        Cell& cell = cells_[size_t{y} * across_ + x];
        cell.touched = true;
        note(cell, worn);
      }
  }

  const glm::dvec2 size_;
  const uint32_t across_, down_;
  std::vector<Cell> cells_;
  Cell whole_;
  bool all_ = false;
};

}  // namespace

uint64_t footprintBytes(const TextureFootprint& footprint) noexcept {
  return sizeof(TextureFootprint) + footprint.tiles.size() * sizeof(TouchedTile) +
         footprint.whole.size() * sizeof(WornTexture);
}

TextureFootprint makeFootprint(const Mesh& mesh, const TextureSet& set, double step) {
  TextureFootprint footprint;
  if (mesh.vertex_attributes.empty() || !mesh.attributes.has(AttributeSet::kTexture)) return footprint;
  std::vector<std::unique_ptr<TouchedGrid>> grids(set.textures.size());
  const double uv_step = uvStep(set);
  uint64_t tests_left = kMaxTileTests;
  for (const glm::u32vec3& triangle : mesh.triangles) {
    const uint32_t number = mesh.vertex_attributes[triangle.x].material;
    if (number >= set.textures.size() || levelCount(set.textures[number]) == 0) continue;
    const Texture& texture = set.textures[number];
    if (!grids[number]) grids[number] = std::make_unique<TouchedGrid>(texture);
    Corners texels;
    ModelCorners model;
    for (int i = 0; i < 3; ++i) {
      const uint32_t vertex = triangle[i];
      const glm::dvec2 uv = set.uv_origin + glm::dvec2(mesh.vertex_attributes[vertex].texture) * uv_step;
      texels[i] = glm::dvec2(uv.x * texture.width, (1 - uv.y) * texture.height);
      model[i] = glm::dvec3(unpackPosition(mesh.positions[vertex])) * step;
    }
    grids[number]->add(texels, model, tests_left);
  }
  uint64_t tiles_left = maxTouchedTiles(mesh.triangles.size()), tiles = 0, whole = 0;
  for (const auto& grid : grids) {
    if (!grid) continue;
    const uint64_t touched = grid->isWhole() ? 0 : grid->touchedTiles();
    if (touched > tiles_left) grid->makeWhole();
    if (grid->isWhole()) {
      ++whole;
    } else {
      tiles_left -= touched;
      tiles += touched;
    }
  }
  footprint.tiles.reserve(tiles);
  footprint.whole.reserve(whole);
  for (uint32_t number = 0; number < grids.size(); ++number)
    if (grids[number]) grids[number]->appendTo(footprint, number);
  return footprint;
}

}  // namespace lode::core
