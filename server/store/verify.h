#pragma once

#include <cstdint>
#include <filesystem>

namespace lode::store {

struct VerifyOptions {
  /// Number of random cuts (see cut.h) whose open edges are compared with the leaves' open edges.
  unsigned random_cuts = 3;
  uint64_t seed = 1;
};

/// Statistics of a successful verification.
struct VerifyReport {
  uint64_t bytes = 0;
  uint64_t blobs = 0;
  uint64_t nodes = 0;
  uint64_t payloads = 0;   ///< number of payloads decoded
  uint64_t triangles = 0;  ///< number of triangles decoded, over all LODs
  uint64_t tiles = 0;      ///< number of texture tiles decoded
  /// Number of open edges in the cut of all leaves; they border holes or the rim of the scan.
  uint64_t open_edges = 0;
  uint64_t cuts = 0;  ///< number of random cuts compared
  /// Largest distance of a cut's open edges from the leaves' open edges, in model units.
  double max_boundary_gap_model = 0;
};

/// Checks all properties of a store that can be checked without its input. Opens the store, which checks its
/// structure. Checks the checksum and digest of every blob. Decodes every texture tile and checks its size.
/// Decodes every payload and checks that its vertices lie inside the node's box and on the lattice (I5), and
/// that it has no more locked vertices than positions. In some random cuts, checks that the distance of each
/// open edge from the leaves' open edges is at most the stored error (I2). Keeps one payload, the open edges
/// and the hierarchy in memory.
/// @throws Error at the first fault, naming file, place and remedy.
VerifyReport verifyStore(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace lode::store
