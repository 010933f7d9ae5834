#include "server/ingest/wedge_values.h"

#include "common/octahedral.h"

namespace lode::ingest {

WedgeTable::WedgeTable(AttributeSet attributes, std::vector<VertexAttributes> codes)
    : attributes_(attributes), codes_(std::move(codes)), values_(codes_.size()), changed_(codes_.size()) {}

WedgeTable::Value WedgeTable::decode(uint32_t wedge) const {
  if (changed_[wedge]) return values_[wedge];
  const VertexAttributes& code = codes_[wedge];
  return {attributes_.has(AttributeSet::kNormal) ? decodeOctahedral(code.normal) : glm::vec3(0),
          glm::vec4(code.colour), glm::vec2(code.texture)};
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
  const Value a = decode(keep), b = decode(gone);
  Value& value = values_[keep];
  value = {glm::mix(a.normal, b.normal, share), glm::mix(a.colour, b.colour, share),
           glm::mix(a.texture, b.texture, share)};
  const float length = glm::length(value.normal);
  value.normal = length > 1e-3f ? value.normal / length : share < 0.5f ? a.normal : b.normal;
  changed_[keep] = 1;
}

VertexAttributes WedgeTable::code(uint32_t wedge) const {
  VertexAttributes code = codes_[wedge];
  if (!changed_[wedge]) return code;
  const Value& value = values_[wedge];
  if (attributes_.has(AttributeSet::kNormal)) code.normal = encodeOctahedral(value.normal);
  code.colour = glm::u8vec4(glm::clamp(value.colour, 0.0f, 255.0f) + 0.5f);
  code.texture = glm::u16vec2(glm::clamp(value.texture, 0.0f, 65535.0f) + 0.5f);
  return code;
}

}  // namespace lode::ingest
