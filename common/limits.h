#pragma once

#include <cstdint>

/// Limits for stores, pages and payloads. Parsers check them before they allocate memory.
/// proto/limits.h has the limits of the protocol.
namespace lode {

constexpr uint32_t kMaxLodTriangles = 1u << 20;  ///< number of triangles of one LOD of a node
constexpr uint32_t kMaxLodVertices = 3u << 20;   ///< number of vertices of one LOD of a node
constexpr uint32_t kMaxBlobBytes = 128u << 20;   ///< size of one blob
constexpr uint32_t kMaxPageBytes = 64u << 10;    ///< size of one hierarchy page
constexpr uint32_t kMaxPageNodes = 73;           ///< number of nodes of one page: 1 + 8 + 64 on three levels
constexpr uint32_t kMaxLods = 64;                ///< number of LODs of one node
constexpr uint64_t kMaxNodes = 1ull << 28;       ///< number of nodes of one model
constexpr uint32_t kMaxModelNameBytes = 255;

}  // namespace lode
