#include "server/ingest/simplify/wedge_quadrics.h"

#include <algorithm>
#include <array>

#include "common/release_storage.h"

namespace lode::ingest {

namespace {

// Weights of attributes. A weight is the length that a difference of attributes counts as, relative to the
// model's diagonal. Larger weights would hardly preserve attributes better, but would increase the geometric
// error.
constexpr double kColourWeight = 0.03;   // length for the full range of a colour
constexpr double kNormalWeight = 0.007;  // length for one radian between normals
// Length for the full range of the texture grid.
constexpr double kTextureWeight = 0.1;
// Least ratio of height to longest side. Thinner triangles have no usable gradient.
constexpr double kThinnest = 1e-2;

}  // namespace

WedgeQuadrics::WedgeQuadrics(CollapseMesh& mesh, double diagonal, double weight) {
  if (!mesh.hasWedges() || weight == 0) return;
  chooseChannels(mesh.attributes, diagonal, weight);
  if (channels_.empty()) return;
  areas_.resize(mesh.wedges.size());
  sums_.resize(mesh.wedges.size() * channels_.size());
  lengths_.reserve(sums_.size());
  for (uint32_t wedge = 0; wedge < mesh.wedges.size(); ++wedge) {
    const WedgeValue value = mesh.wedges.value(wedge);
    for (const auto [part, scale] : channels_) lengths_.push_back(scale * value.parts[part]);
  }
  for (uint32_t c = 0; c < mesh.corner_position.size(); c += 4) addTriangle(mesh, c);
  releaseStorage(lengths_);
}

void WedgeQuadrics::chooseChannels(AttributeSet attributes, double diagonal, double weight) {
  const auto add = [&](int first, int count, double scale) {
    for (int i = 0; i < count; ++i) channels_.push_back({first + i, weight * diagonal * scale});
  };
  const bool computed = attributes.has(AttributeSet::kComputedNormal);
  if (attributes.has(AttributeSet::kNormal) && !computed) add(WedgeValue::kNormal, 3, kNormalWeight);
  if (attributes.has(AttributeSet::kColour)) add(WedgeValue::kColour, 3, kColourWeight / 255);
  if (attributes.has(AttributeSet::kTexture)) add(WedgeValue::kTexture, 2, kTextureWeight / 65535);
  covers_all_ = (computed || !channels_.empty()) && !attributes.has(AttributeSet::kAlpha);
}

void WedgeQuadrics::addTriangle(CollapseMesh& mesh, uint32_t corner) {
  const std::array<uint32_t, 3> at{mesh.at(corner), mesh.at(corner + 1), mesh.at(corner + 2)};
  const glm::dvec3 p = mesh.point(at[0]), e1 = mesh.point(at[1]) - p, e2 = mesh.point(at[2]) - p;
  const glm::dvec3 normal = glm::cross(e1, e2);
  const double square = glm::dot(normal, normal), area = 0.5 * glm::length(normal);
  if (area == 0) return;
  const double longest = std::max({glm::dot(e1, e1), glm::dot(e2, e2), glm::dot(e2 - e1, e2 - e1)});
  const bool thin = square < kThinnest * kThinnest * longest * longest;
  const glm::dvec3 along1 = glm::cross(e2, normal) / square, along2 = glm::cross(normal, e1) / square;
  const std::array<uint32_t, 3> wedges{mesh.corner_wedge[corner], mesh.corner_wedge[corner + 1],
                                       mesh.corner_wedge[corner + 2]};
  for (const uint32_t wedge : wedges) areas_[wedge] += area;
  Quadric squares;
  for (size_t i = 0; i < channels_.size(); ++i) {
    const double s0 = lengths_[wedges[0] * channels_.size() + i],
                 s1 = lengths_[wedges[1] * channels_.size() + i],
                 s2 = lengths_[wedges[2] * channels_.size() + i];
    const glm::dvec3 g = thin ? glm::dvec3(0) : (s1 - s0) * along1 + (s2 - s0) * along2;
    const double d = thin ? (s0 + s1 + s2) / 3 : s0 - glm::dot(g, p);
    squares.addPlane(g, d, area);
    for (const uint32_t wedge : wedges) {
      Sum& sum = sums_[wedge * channels_.size() + i];
      sum.g += area * g;
      sum.d += area * d;
    }
  }
  for (const uint32_t position : at) mesh.quadrics[position] += squares;
}

void WedgeQuadrics::prefetch(uint32_t wedge) const noexcept {
  __builtin_prefetch(&areas_[wedge]);
  const char* const first = reinterpret_cast<const char*>(&sums_[wedge * channels_.size()]);
  for (size_t byte = 0; byte < channels_.size() * sizeof(Sum); byte += 64) __builtin_prefetch(first + byte);
}

void WedgeQuadrics::reduce(Quadric& q, uint32_t wedge) const noexcept {
  if (areas_[wedge] <= 0) return;
  const double weight = -1 / areas_[wedge];
  const Sum* const sums = &sums_[wedge * channels_.size()];
  for (size_t i = 0; i < channels_.size(); ++i) q.addPlane(sums[i].g, sums[i].d, weight);
}

void WedgeQuadrics::reduce(Quadric& q, uint32_t wedge, uint32_t other) const noexcept {
  const double area = areas_[wedge] + areas_[other];
  if (area <= 0) return;
  const Sum *a = &sums_[wedge * channels_.size()], *b = &sums_[other * channels_.size()];
  Quadric squares;
  for (const Sum* const end = a + channels_.size(); a != end; ++a, ++b)
    squares.addPlane(a->g + b->g, a->d + b->d, 1);
  q.subtract(squares, 1 / area);
}

void WedgeQuadrics::join(uint32_t keep, uint32_t gone) noexcept {
  areas_[keep] += areas_[gone];
  for (size_t i = 0; i < channels_.size(); ++i) {
    Sum& sum = sums_[keep * channels_.size() + i];
    const Sum& other = sums_[gone * channels_.size() + i];
    sum.g += other.g;
    sum.d += other.d;
  }
}

void WedgeQuadrics::setValues(WedgeTable& wedges, uint32_t wedge, glm::dvec3 point) const {
  if (areas_[wedge] <= 0) return;
  WedgeValue value = wedges.value(wedge);
  for (size_t i = 0; i < channels_.size(); ++i) {
    const Sum& sum = sums_[wedge * channels_.size() + i];
    value.parts[channels_[i].part] =
        static_cast<float>((glm::dot(sum.g, point) + sum.d) / (areas_[wedge] * channels_[i].scale));
  }
  wedges.set(wedge, value);
}

}  // namespace lode::ingest
