#pragma once

#include <compare>
#include <cstdint>

#include "common/node_key.h"

namespace lode::core {

/// Names one mesh of a model.
struct MeshKey {
  NodeKey node;
  uint32_t lod = 0;
  friend constexpr auto operator<=>(const MeshKey&, const MeshKey&) = default;
};

}  // namespace lode::core
