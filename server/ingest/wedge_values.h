#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::ingest {

/// The attributes of the wedges of a mesh that is simplified: exact codes, and values once a wedge has
/// changed.
class WedgeTable {
 public:
  struct Pair {
    uint32_t keep, gone;
  };

  WedgeTable() = default;
  WedgeTable(AttributeSet attributes, std::vector<VertexAttributes> codes);

  size_t size() const noexcept { return codes_.size(); }
  /// `keep` becomes the mix of both, `gone_share` of it the other's. A share of 0 or 1 copies exactly.
  void mix(uint32_t keep, uint32_t gone, double gone_share);
  /// Attributes on the model's grids.
  VertexAttributes code(uint32_t wedge) const;

 private:
  struct Value {
    glm::vec3 normal;
    glm::vec4 colour;
    glm::vec2 texture;
  };
  Value decode(uint32_t wedge) const;

  AttributeSet attributes_;
  std::vector<VertexAttributes> codes_;
  std::vector<Value> values_;  // where changed_
  std::vector<uint8_t> changed_;
};

}  // namespace lode::ingest
