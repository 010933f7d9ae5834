#pragma once

#include <cstdint>

namespace lode::ingest {

/// How the LODs of a node are made.
enum class Simplifier : uint8_t {
  kCollapse,  ///< collapse(): best for its triangles
  kCluster,   ///< cluster(): a fast preview, and the paper's method
};

}  // namespace lode::ingest
