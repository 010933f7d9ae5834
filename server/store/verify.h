#pragma once

#include <cstdint>
#include <filesystem>

namespace lode::store {

struct VerifyOptions {
  unsigned random_cuts = 3;  ///< number of random cuts whose boundaries are compared with the leaves'
  uint64_t seed = 1;
};

/// Statistics of a successful verification.
struct VerifyReport {
  uint64_t bytes = 0;
  uint64_t blobs = 0;
  uint64_t nodes = 0;
  uint64_t payloads = 0;    ///< number of payloads decoded
  uint64_t triangles = 0;   ///< number of triangles decoded, over all LODs
  uint64_t tiles = 0;       ///< number of texture tiles decoded
  uint64_t open_edges = 0;  ///< open edges in the cut of all leaves: holes and boundaries of the scan
  uint64_t cuts = 0;        ///< number of random cuts compared
  /// Largest distance of a cut's open edges from the leaves' open edges, in model units.
  double max_boundary_gap_model = 0;
};

/// Checks all properties of a store that can be checked without its input. Opens the store, which checks its
/// structure. Checks the checksum and digest of every blob. Decodes every texture tile and checks its size.
/// Decodes every payload and checks that its vertices lie inside the node's box (decoded positions are on the
/// lattice, I5) and that its number of locked vertices is possible. Checks in some random cuts that open
/// edges are no farther from the leaves' open edges than the stored error (I2). Keeps one payload, the open
/// edges and the hierarchy in memory.
/// @throws Error at the first fault, naming file, place and remedy.
VerifyReport verifyStore(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace lode::store
