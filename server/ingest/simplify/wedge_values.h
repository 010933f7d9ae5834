#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace lode::ingest {

/// Attributes of a wedge (one set of attributes at a position) as floats, in steps of the model's attribute
/// grids. A normal is a unit vector.
struct WedgeValue {
  // Index of each attribute's first part, and the number of parts. A colour has four parts, with alpha.
  static constexpr int kNormal = 0, kColour = 3, kTexture = 7, kParts = 9;
  std::array<float, kParts> parts{};
};

/// Attributes of the wedges during simplification. Unchanged wedges keep their exact codes; changed wedges
/// have a WedgeValue.
class WedgeTable {
 public:
  struct Pair {
    uint32_t keep, gone;
  };

  WedgeTable() = default;
  WedgeTable(AttributeSet attributes, std::vector<VertexAttributes> codes);

  size_t size() const noexcept { return codes_.size(); }
  WedgeValue value(uint32_t wedge) const;
  /// Sets the value of a wedge. Normalizes the normal and clamps other values to their grids.
  void set(uint32_t wedge, const WedgeValue& value);
  /// Sets the attributes of `keep` to a weighted mean of both wedges; `gone` has the weight gone_share. With
  /// a weight of 0 or 1, the result is an exact copy.
  void mix(uint32_t keep, uint32_t gone, double gone_share);
  /// Returns a wedge's attributes, rounded to the model's grids.
  VertexAttributes code(uint32_t wedge) const;

 private:
  AttributeSet attributes_;
  int end_ = 0;  // number of leading parts of WedgeValue that the model uses
  std::vector<VertexAttributes> codes_;
  std::vector<WedgeValue> values_;  // valid where changed_ is set
  std::vector<uint8_t> changed_;
};

}  // namespace lode::ingest
