#pragma once

#include <cstdint>
#include <filesystem>

namespace lode::store {

struct VerifyOptions {
  unsigned random_cuts = 3;  ///< whose boundaries are compared with the leaves'
  uint64_t seed = 1;
};

/// What was looked at; that it was sound is said by verifyStore() returning.
struct VerifyReport {
  uint64_t bytes = 0;
  uint64_t blobs = 0;
  uint64_t nodes = 0;
  uint64_t payloads = 0;              ///< decoded
  uint64_t triangles = 0;             ///< decoded, over all LODs
  uint64_t tiles = 0;                 ///< of textures, decoded
  uint64_t open_edges = 0;            ///< of the leaves' cut: holes and boundaries of the scan
  uint64_t cuts = 0;                  ///< random cuts compared
  double max_boundary_gap_model = 0;  ///< largest distance of such a cut's open edges from the leaves' ones
};

/// Checks everything that a store shows without its input: what opening checks, every blob's checksum and
/// name, every tile of the textures decoded to its size, every payload decoded with all guards, its
/// triangles, its vertices inside the node's box (on the lattice by construction, I5), locked counts, and for
/// some random cuts that open edges lie within the stored error of the leaves' open edges (I2). Memory: one
/// payload, the open edges and the hierarchy.
/// @throws Error at the first fault, naming file, place and remedy.
VerifyReport verifyStore(const std::filesystem::path& path, const VerifyOptions& options = {});

}  // namespace lode::store
