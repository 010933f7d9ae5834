#include "server/ingest/measure/lost_detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/codec/octahedral.h"

namespace lode::ingest {
namespace {

/// Larger differences in any colour channel (0 to 255) count as lost detail.
constexpr float kColourThreshold = 8;
/// Larger differences between normals count as lost detail. The value is the distance between two unit
/// vectors about 20 degrees apart.
constexpr float kNormalThreshold = 0.3473f;
constexpr float kComputedThreshold = 0.684f;  ///< the same for computed normals, about 40 degrees apart
/// Share of the LOD's area, made up of its worst triangles, that is ignored.
constexpr double kIgnoredArea = 1.0 / 1024;

/// Attributes of a point as floats.
struct Value {
  glm::vec4 colour{0};
  glm::vec3 normal{0};
  glm::vec2 texture{0};
};

/// Compares the attributes at the input's positions with the attributes of the LOD at the same places.
class DetailMeter {
 public:
  DetailMeter(const SimplifiedMesh& lod, const NodeMesh& input)
      : lod_(lod.mesh),
        input_(input),
        counts_colour_(input.attributes.has(AttributeSet::kColour | AttributeSet::kAlpha)),
        counts_normal_(input.attributes.has(AttributeSet::kNormal)),
        counts_texture_(input.attributes.has(AttributeSet::kTexture)),
        normal_threshold_(input.attributes.has(AttributeSet::kComputedNormal) ? kComputedThreshold
                                                                              : kNormalThreshold),
        found_(lod.mesh.triangles.size()) {
    if (!countsAny()) return;
    values_.reserve(lod_.wedge_attributes.size());
    for (const VertexAttributes& attributes : lod_.wedge_attributes) values_.push_back(valueOf(attributes));
  }

  bool countsAny() const noexcept { return counts_colour_ || counts_normal_ || counts_texture_; }

  /// Compares a position of the input with the LOD at `place`. Of the position's wedges (its sets of
  /// attributes, see NodeMesh), only the one most similar to the LOD counts, because `place` lies on one side
  /// of a seam.
  void add(std::span<const uint32_t> wedges, SurfaceWalk::Place place);
  float size() const;

 private:
  /// Differences found on one triangle of the LOD.
  struct Found {
    glm::vec4 colour{0};  ///< sum of the colour differences
    glm::vec3 normal{0};
    float count = 0;
    float slide = 0;  ///< largest difference of texture coordinates, in steps of the texture grid
  };

  Value valueOf(const VertexAttributes& attributes) const;
  glm::vec3 pointOf(uint32_t wedge) const {
    return glm::vec3(unpackPosition(lod_.positions[lod_.wedge_position[wedge]]));
  }
  /// Returns the number of lattice steps per step of the texture grid on a triangle.
  float stretchOf(const glm::u32vec3& t) const;

  const NodeMesh& lod_;
  const NodeMesh& input_;
  const bool counts_colour_, counts_normal_, counts_texture_;
  const float normal_threshold_;
  std::vector<Value> values_;  ///< attributes of the LOD's wedges
  std::vector<Found> found_;   ///< differences between LOD and input, by triangle of the LOD
};

Value DetailMeter::valueOf(const VertexAttributes& attributes) const {
  Value value;
  if (counts_colour_) value.colour = glm::vec4(attributes.colour);
  if (counts_normal_) value.normal = decodeOctahedral(attributes.normal);
  if (counts_texture_) value.texture = glm::vec2(attributes.texture);
  return value;
}

float DetailMeter::stretchOf(const glm::u32vec3& t) const {
  const glm::vec3 a = pointOf(t.x);
  const float area = glm::length(glm::cross(pointOf(t.y) - a, pointOf(t.z) - a));
  const glm::vec2 u(lod_.wedge_attributes[t.x].texture), v(lod_.wedge_attributes[t.y].texture),
      w(lod_.wedge_attributes[t.z].texture);
  const float mapped = std::abs((v.x - u.x) * (w.y - u.y) - (v.y - u.y) * (w.x - u.x));
  return mapped > 0 ? std::sqrt(area / mapped) : 0;
}

void DetailMeter::add(std::span<const uint32_t> wedges, SurfaceWalk::Place place) {
  const glm::u32vec3& t = lod_.triangles[place.triangle];
  const std::array<const Value*, 3> corners{&values_[t.x], &values_[t.y], &values_[t.z]};
  Value here;
  for (int k = 0; k < 3; ++k) {
    if (counts_colour_) here.colour += place.shares[k] * corners[k]->colour;
    if (counts_normal_) here.normal += place.shares[k] * corners[k]->normal;
    if (counts_texture_) here.texture += place.shares[k] * corners[k]->texture;
  }
  const uint16_t material = lod_.wedge_attributes[t.x].material;
  Value least;
  float least_sum = std::numeric_limits<float>::infinity();
  for (const uint32_t wedge : wedges) {
    const VertexAttributes& attributes = input_.wedge_attributes[wedge];
    if (attributes.material != material) continue;
    const Value value = valueOf(attributes);
    Value off;
    if (counts_colour_) off.colour = value.colour - here.colour;
    if (counts_normal_) off.normal = value.normal - here.normal;
    if (counts_texture_) off.texture = value.texture - here.texture;
    const float sum = wedges.size() == 1 ? 0
                                         : glm::length(off.colour) / 255 + glm::length(off.normal) +
                                               glm::length(off.texture) / 65535;
    if (sum >= least_sum) continue;
    least_sum = sum;
    least = off;
  }
  if (std::isinf(least_sum)) return;
  Found& found = found_[place.triangle];
  found.count += 1;
  if (counts_colour_) found.colour += least.colour;
  if (counts_normal_) found.normal += least.normal;
  if (counts_texture_) found.slide = std::max(found.slide, glm::length(least.texture));
}

float DetailMeter::size() const {
  struct Lost {
    float size;
    double area;
  };
  std::vector<Lost> lost;
  double area = 0;
  for (size_t i = 0; i < found_.size(); ++i) {
    const glm::u32vec3& t = lod_.triangles[i];
    const glm::vec3 a = pointOf(t.x), ab = pointOf(t.y) - a, ac = pointOf(t.z) - a;
    const double triangle_area = glm::length(glm::cross(ab, ac));
    area += triangle_area;
    const Found& found = found_[i];
    if (found.count == 0) continue;
    const glm::vec4 colour = glm::abs(found.colour / found.count);
    const bool is_off = std::max({colour.x, colour.y, colour.z, colour.w}) > kColourThreshold ||
                        glm::length(found.normal / found.count) > normal_threshold_;
    const auto side = static_cast<float>(std::sqrt(triangle_area / 2));
    const float slide = counts_texture_ ? found.slide * stretchOf(t) : 0;
    const float size = is_off ? std::max(side, slide) : slide;
    if (size > 0) lost.push_back({size, triangle_area});
  }
  std::sort(lost.begin(), lost.end(), [](const Lost& a, const Lost& b) { return a.size > b.size; });
  double above = 0;
  for (const Lost& l : lost) {
    above += l.area;
    if (above > kIgnoredArea * area) return l.size;
  }
  return 0;
}

}  // namespace

float lostDetail(const SimplifiedMesh& lod, const NodeMesh& input,
                 std::span<const SurfaceWalk::Place> places) {
  DetailMeter meter(lod, input);
  if (!meter.countsAny() || lod.mesh.triangles.empty()) return 0;
  std::vector<uint32_t> begin(input.positions.size() + 1), wedges(input.wedge_position.size());
  for (const uint32_t position : input.wedge_position) ++begin[position];
  uint32_t end = 0;
  for (uint32_t& first : begin) first = end += first;
  for (auto wedge = static_cast<uint32_t>(wedges.size()); wedge-- > 0;)
    wedges[--begin[input.wedge_position[wedge]]] = wedge;
  for (size_t i = 0; i < input.positions.size(); ++i) {
    if (lod.remap[i] == kVanished) continue;
    meter.add(std::span(wedges).subspan(begin[i], begin[i + 1] - begin[i]), places[i]);
  }
  return meter.size();
}

}  // namespace lode::ingest
