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
  uint64_t payloads = 0;              ///< decoded
  uint64_t triangles = 0;             ///< decoded, over all LODs
  uint64_t tiles = 0;                 ///< decoded tiles of textures
  uint64_t open_edges = 0;            ///< in the leaves' cut: holes and boundaries of the scan
  uint64_t cuts = 0;                  ///< random cuts compared
  double max_boundary_gap_model = 0;  ///< largest distance of a cut's open edges from the leaves'
};

/// Checks everything that a store reveals without its input: everything that opening checks; checksum and
/// digest of every blob; every texture tile decoded to its size; every payload decoded and validated, with
/// vertices inside the node's box (decoded positions are on the lattice, I5) and locked counts; and in some
/// random cuts, that open edges lie within the stored error of the leaves' open edges (I2). Memory: one
/// payload, the open edges and the hierarchy.
/// @throws Error at the first fault, naming file, place and remedy.
VerifyReport verifyStore(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace lode::store
