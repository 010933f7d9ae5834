#include "server/tiles/tile_textures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "server/tiles/chart.h"

namespace lode::tiles {
namespace {

constexpr uint32_t kNone = static_cast<uint32_t>(-1);
/// A texture's charts share a whole level if they need at least this share of its texels.
constexpr double kShareOfWhole = 0.5;
/// Fractional bits of texture coordinates in an atlas: the precision is 1/8 texel.
constexpr int kSubtexelBits = 3;

double areaOf(glm::uvec2 size) { return static_cast<double>(size.x) * size.y; }

/// Returns the coarsest level with texels no larger than an error.
uint32_t levelFor(double area_uv, double area_model, double error_model, glm::uvec2 size, uint32_t coarsest) {
  const double texels_per_model = std::sqrt(area_uv * areaOf(size) / area_model);
  const double texels = texels_per_model * error_model;  // NaN if the area is 0
  if (!(texels >= 2)) return 0;
  return static_cast<uint32_t>(std::min(std::floor(std::log2(texels)), static_cast<double>(coarsest)));
}

/// Chooses the images of an LOD's charts.
class ImageChoice {
 public:
  ImageChoice(const Charts& charts, const TextureSet& textures, double error_model, TextureLevels& levels)
      : charts_(charts), textures_(textures), error_model_(error_model), levels_(levels) {
    chooseShared();
    for (uint32_t coarser = 0;; ++coarser) {
      placeInAtlas(coarser);
      if (std::max(atlas_size_.x, atlas_size_.y) <= kMostImagePx) break;
    }
  }

  /// Returns the whole level that a chart shows, or null.
  const SharedImage* sharedOf(uint32_t chart) const {
    const auto found = shared_.find(charts_.charts[chart].material);
    return found == shared_.end() ? nullptr : &found->second;
  }
  bool isInAtlas(uint32_t chart) const { return piece_of_[chart] != kNone; }
  bool hasAtlas() const noexcept { return !pieces_.empty(); }
  Atlas paint() const { return paintAtlas(pieces_, atlas_size_, levels_); }
  glm::uvec2 atlasSize() const noexcept { return atlas_size_; }
  /// Converts true texture coordinates of a chart in the atlas to texels of the atlas, from the top left.
  glm::dvec2 toAtlas(uint32_t chart, glm::dvec2 uv) const {
    const AtlasPiece& piece = pieces_[piece_of_[chart]];
    return texelsOf(chart, uv, piece.level) - glm::dvec2(piece.first) + glm::dvec2(piece.place);
  }

 private:
  bool hasImage(const Chart& chart) const {
    return chart.material < textures_.textures.size() && !textures_.textures[chart.material].tiles.empty();
  }

  /// Returns true if a chart shows a part of its image more than once.
  static bool repeats(const Chart& chart) {
    const glm::dvec2 extent = chart.most - chart.least;
    return extent.x > 1 || extent.y > 1;
  }

  /// Converts texture coordinates to texels of a level. The chart begins in one copy of the repeated image;
  /// the origin is the top left of this copy.
  glm::dvec2 texelsOf(uint32_t chart, glm::dvec2 uv, uint32_t level) const {
    const Chart& of = charts_.charts[chart];
    const glm::dvec2 whole = glm::floor(of.least), size = glm::dvec2(levels_.size(of.material, level));
    return glm::dvec2(uv.x - whole.x, whole.y + 1 - uv.y) * size;
  }

  AtlasPiece pieceOf(uint32_t chart, uint32_t level) const {
    const Chart& of = charts_.charts[chart];
    const glm::dvec2 a = texelsOf(chart, {of.least.x, of.most.y}, level);
    const glm::dvec2 b = texelsOf(chart, {of.most.x, of.least.y}, level);
    return {.texture = of.material,
            .level = level,
            .first = glm::ivec2(glm::floor(a)) - kGutterPx,
            .end = glm::ivec2(glm::ceil(b)) + kGutterPx};
  }

  uint32_t levelOf(const Chart& chart) const {
    return levelFor(chart.area_uv, chart.area_model, error_model_, levels_.size(chart.material, 0),
                    levels_.coarsest(chart.material));
  }

  /// Finds the textures whose charts show a whole level.
  void chooseShared() {
    struct Use {
      Chart sum;
      double share = 0;
      bool repeats = false;
    };
    std::map<uint16_t, Use> uses;
    for (uint32_t i = 0; i < charts_.charts.size(); ++i) {
      const Chart& chart = charts_.charts[i];
      if (!hasImage(chart)) continue;
      Use& use = uses[chart.material];
      use.sum.material = chart.material;
      use.sum.area_uv += chart.area_uv;
      use.sum.area_model += chart.area_model;
      use.repeats |= repeats(chart);
      if (use.repeats) continue;
      const AtlasPiece piece = pieceOf(i, levelOf(chart));
      use.share += static_cast<double>(piece.area()) / areaOf(levels_.size(chart.material, piece.level));
    }
    for (const auto& [material, use] : uses)
      if (use.repeats || use.share >= kShareOfWhole) shared_[material] = {material, levelOfWhole(use.sum)};
  }

  uint32_t levelOfWhole(const Chart& sum) const {
    uint32_t level = levelOf(sum);
    const auto isTooLarge = [&](glm::uvec2 size) { return std::max(size.x, size.y) > kMostImagePx; };
    while (isTooLarge(levels_.size(sum.material, level))) ++level;
    return level;
  }

  /// Places all other charts in the atlas.
  /// @param coarser  number of levels by which to coarsen the charts, so that the atlas fits.
  void placeInAtlas(uint32_t coarser) {
    piece_of_.assign(charts_.charts.size(), kNone);
    pieces_.clear();
    std::vector<uint32_t> chart_of;
    for (uint32_t i = 0; i < charts_.charts.size(); ++i) {
      const Chart& chart = charts_.charts[i];
      if (!hasImage(chart) || shared_.contains(chart.material)) continue;
      chart_of.push_back(i);
      pieces_.push_back(pieceOf(i, std::min(levelOf(chart) + coarser, levels_.coarsest(chart.material))));
    }
    const std::vector<uint32_t> owners = joinPieces(pieces_);
    for (size_t i = 0; i < owners.size(); ++i) piece_of_[chart_of[i]] = owners[i];
    atlas_size_ = placePieces(pieces_);
  }

  const Charts& charts_;
  const TextureSet& textures_;
  const double error_model_;
  TextureLevels& levels_;
  std::map<uint16_t, SharedImage> shared_;  ///< by material
  std::vector<AtlasPiece> pieces_;
  std::vector<uint32_t> piece_of_;  ///< for each chart, its piece, or kNone
  glm::uvec2 atlas_size_{0};
};

/// Collects the triangles of one part.
class PartMaker {
 public:
  explicit PartMaker(const Mesh& whole) : whole_(whole), copy_of_(whole.positions.size(), kNone) {
    part_.mesh.attributes = whole.attributes;
  }

  void add(glm::u32vec3 triangle) {
    for (int k = 0; k < 3; ++k) {
      uint32_t& copy = copy_of_[triangle[k]];
      if (copy == kNone) {
        copy = static_cast<uint32_t>(vertices_.size());
        vertices_.push_back(triangle[k]);
        part_.mesh.positions.push_back(whole_.positions[triangle[k]]);
        part_.mesh.vertex_attributes.push_back(whole_.vertex_attributes[triangle[k]]);
      }
      triangle[k] = copy;
    }
    part_.mesh.triangles.push_back(triangle);
  }

  /// Returns for each vertex of the part its index in the whole mesh.
  std::span<const uint32_t> vertices() const noexcept { return vertices_; }
  TexturedPart& part() noexcept { return part_; }

 private:
  const Mesh& whole_;
  std::vector<uint32_t> copy_of_, vertices_;
  TexturedPart part_;
};

void pointIntoAtlas(PartMaker& maker, const Mesh& mesh, const Charts& charts, const TextureSet& textures,
                    const ImageChoice& choice) {
  TexturedPart& part = maker.part();
  const glm::uvec2 size = choice.atlasSize();
  const int bits = std::bit_width(std::max(size.x, size.y) - 1) + kSubtexelBits;
  const double codes = std::ldexp(1.0, bits);
  part.coordinates = {.origin = {0, 0}, .step = 1 / codes, .bits = bits};
  for (size_t i = 0; i < maker.vertices().size(); ++i) {
    const uint32_t vertex = maker.vertices()[i];
    const glm::dvec2 uv = trueTextureCoordinates(textures, mesh.vertex_attributes[vertex]);
    const glm::dvec2 at = choice.toAtlas(charts.of_vertex[vertex], uv) / glm::dvec2(size);
    part.mesh.vertex_attributes[i].texture =
        glm::u16vec2(glm::clamp(glm::round(at * codes), glm::dvec2(0), glm::dvec2(codes - 1)));
  }
}

/// Rewrites a part's codes so that v points down, as in glTF, and the smallest code is 0.
void pointIntoWhole(TexturedPart& part, const TextureSet& textures) {
  std::vector<VertexAttributes>& vertices = part.mesh.vertex_attributes;
  glm::uvec2 least(0xffff), most(0);
  for (const VertexAttributes& vertex : vertices) {
    least = glm::min(least, glm::uvec2(vertex.texture));
    most = glm::max(most, glm::uvec2(vertex.texture));
  }
  for (VertexAttributes& vertex : vertices)
    vertex.texture = {vertex.texture.x - least.x, most.y - vertex.texture.y};
  const double step = uvStep(textures);
  const glm::dvec2 origin(textures.uv_origin.x + least.x * step, 1 - textures.uv_origin.y - most.y * step);
  const glm::uvec2 range = most - least;
  part.coordinates = {.origin = glm::vec2(origin - glm::floor(origin)),
                      .step = step,
                      .bits = std::max(1, static_cast<int>(std::bit_width(std::max(range.x, range.y))))};
}

}  // namespace

TexturedLod textureLod(const Mesh& mesh, const TextureSet& textures, double step, double error_model,
                       TextureLevels& levels) {
  const Charts charts = findCharts(mesh, textures, step);
  const ImageChoice choice(charts, textures, error_model, levels);
  std::map<std::pair<TexturedPart::Source, SharedImage>, PartMaker> makers;
  for (const glm::u32vec3 triangle : mesh.triangles) {
    const uint32_t chart = charts.of_vertex[triangle.x];
    const SharedImage* const shared = choice.sharedOf(chart);
    const auto source = shared                    ? TexturedPart::Source::kShared
                        : choice.isInAtlas(chart) ? TexturedPart::Source::kAtlas
                                                  : TexturedPart::Source::kNone;
    const std::pair key(source, shared ? *shared : SharedImage());
    makers.try_emplace(key, mesh).first->second.add(triangle);
  }
  TexturedLod lod;
  for (auto& [key, maker] : makers) {
    TexturedPart& part = maker.part();
    std::tie(part.source, part.shared) = key;
    if (part.source == TexturedPart::Source::kAtlas) pointIntoAtlas(maker, mesh, charts, textures, choice);
    if (part.source == TexturedPart::Source::kShared) pointIntoWhole(part, textures);
    lod.parts.push_back(std::move(part));
  }
  if (choice.hasAtlas()) lod.atlas = choice.paint();
  return lod;
}

}  // namespace lode::tiles
