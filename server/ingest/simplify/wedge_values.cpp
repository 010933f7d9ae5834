#include "server/ingest/simplify/wedge_values.h"

#include <algorithm>
#include <cmath>

#include "common/codec/octahedral.h"

namespace lode::ingest {

WedgeTable::WedgeTable(AttributeSet attributes, std::vector<VertexAttributes> codes)
    : attributes_(attributes), codes_(std::move(codes)), values_(codes_.size()), changed_(codes_.size()) {
  const bool normals_alone = !attributes.has(AttributeSet::kColour) &&
                             !attributes.has(AttributeSet::kAlpha) && !attributes.has(AttributeSet::kTexture);
  end_ = normals_alone ? WedgeValue::kColour : WedgeValue::kParts;
}

WedgeValue WedgeTable::value(uint32_t wedge) const {
  if (changed_[wedge]) return values_[wedge];
  const VertexAttributes& code = codes_[wedge];
  WedgeValue value;
  float* const parts = value.parts.data();
  if (attributes_.has(AttributeSet::kNormal)) {
    const glm::vec3 normal = decodeOctahedral(code.normal);
    for (int i = 0; i < 3; ++i) parts[WedgeValue::kNormal + i] = normal[i];
  }
  if (end_ <= WedgeValue::kColour) return value;
  for (int i = 0; i < 4; ++i) parts[WedgeValue::kColour + i] = code.colour[i];
  for (int i = 0; i < 2; ++i) parts[WedgeValue::kTexture + i] = code.texture[i];
  return value;
}

void WedgeTable::set(uint32_t wedge, const WedgeValue& value) {
  constexpr float kShortestNormal = 1e-3f;
  const float* const given = value.parts.data();
  float* const parts = values_[wedge].parts.data();
  if (attributes_.has(AttributeSet::kNormal)) {
    const float length = std::sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2]);
    const bool keeps = length <= kShortestNormal;
    const WedgeValue old = keeps ? this->value(wedge) : WedgeValue{};
    for (int i = WedgeValue::kNormal; i < WedgeValue::kNormal + 3; ++i)
      parts[i] = keeps ? old.parts[static_cast<size_t>(i)] : given[i] / length;
  }
  if (end_ > WedgeValue::kColour) {
    for (int i = WedgeValue::kColour; i < WedgeValue::kColour + 4; ++i)
      parts[i] = std::clamp(given[i], 0.0f, 255.0f);
    for (int i = WedgeValue::kTexture; i < WedgeValue::kTexture + 2; ++i)
      parts[i] = std::clamp(given[i], 0.0f, 65535.0f);
  }
  changed_[wedge] = 1;
}

void WedgeTable::mix(uint32_t keep, uint32_t gone, double gone_share) {
  if (gone_share <= 0 || (!changed_[keep] && !changed_[gone] && codes_[keep] == codes_[gone])) return;
  if (gone_share >= 1) {
    codes_[keep] = codes_[gone];
    values_[keep] = values_[gone];
    changed_[keep] = changed_[gone];
    return;
  }
  const float share = static_cast<float>(gone_share);
  WedgeValue mixed = value(keep);
  const WedgeValue other = value(gone);
  for (size_t i = 0; i < static_cast<size_t>(end_); ++i)
    mixed.parts[i] = (1 - share) * mixed.parts[i] + share * other.parts[i];
  set(keep, mixed);
}

VertexAttributes WedgeTable::code(uint32_t wedge) const {
  VertexAttributes code = codes_[wedge];
  if (!changed_[wedge]) return code;
  const float* const parts = values_[wedge].parts.data();
  if (attributes_.has(AttributeSet::kNormal)) code.normal = encodeOctahedral({parts[0], parts[1], parts[2]});
  if (end_ <= WedgeValue::kColour) return code;
  for (int i = 0; i < 4; ++i) code.colour[i] = static_cast<uint8_t>(parts[WedgeValue::kColour + i] + 0.5f);
  for (int i = 0; i < 2; ++i) code.texture[i] = static_cast<uint16_t>(parts[WedgeValue::kTexture + i] + 0.5f);
  return code;
}

}  // namespace lode::ingest
