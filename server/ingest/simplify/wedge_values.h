#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

/// The attributes of a wedge as numbers on the model's grids (a normal as a vector).
struct WedgeValue {
  static constexpr int kNormal = 0, kColour = 3, kTexture = 7, kParts = 9;  // colour with alpha
  std::array<float, kParts> parts{};
};

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
  WedgeValue value(uint32_t wedge) const;
  /// Normals are made unit; values outside their grid are clamped.
  void set(uint32_t wedge, const WedgeValue& value);
  /// `keep` becomes the mix of both, `gone_share` of it the other's. A share of 0 or 1 copies exactly.
  void mix(uint32_t keep, uint32_t gone, double gone_share);
  /// Attributes on the model's grids.
  VertexAttributes code(uint32_t wedge) const;

 private:
  AttributeSet attributes_;
  int end_ = 0;  // of the parts that the model has
  std::vector<VertexAttributes> codes_;
  std::vector<WedgeValue> values_;  // where changed_
  std::vector<uint8_t> changed_;
};

}  // namespace lode::ingest
