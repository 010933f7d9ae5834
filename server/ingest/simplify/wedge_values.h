#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

/// Attributes of a wedge as floats on the model's grids; a normal is a vector.
struct WedgeValue {
  static constexpr int kNormal = 0, kColour = 3, kTexture = 7, kParts = 9;  // colour includes alpha
  std::array<float, kParts> parts{};
};

/// Attributes of the wedges during simplification: exact codes, replaced by values once a wedge has changed.
class WedgeTable {
 public:
  struct Pair {
    uint32_t keep, gone;
  };

  WedgeTable() = default;
  WedgeTable(AttributeSet attributes, std::vector<VertexAttributes> codes);

  size_t size() const noexcept { return codes_.size(); }
  WedgeValue value(uint32_t wedge) const;
  /// Normalizes normals and clamps other values to their grids.
  void set(uint32_t wedge, const WedgeValue& value);
  /// Mixes `gone` into `keep` with weight gone_share. A share of 0 or 1 copies exactly.
  void mix(uint32_t keep, uint32_t gone, double gone_share);
  /// Attributes rounded to the model's grids.
  VertexAttributes code(uint32_t wedge) const;

 private:
  AttributeSet attributes_;
  int end_ = 0;  // end of the parts that the model has
  std::vector<VertexAttributes> codes_;
  std::vector<WedgeValue> values_;  // valid where changed_ is set
  std::vector<uint8_t> changed_;
};

}  // namespace lode::ingest
