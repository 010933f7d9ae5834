#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "server/ingest/inspect/error_witness.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

struct AgainstOptions {
  std::filesystem::path store, input;
  std::filesystem::path temporary_folder;  ///< folder for temporary files; empty: the system's folder
  uint64_t memory_bytes = 0;               ///< memory for sorting; 0: defaultMemoryBytes()
  unsigned threads = 0;                    ///< number of threads; 0: one per core
  size_t lods = 0;                         ///< number of LODs to measure, spread evenly over the tree; 0: all
  uint64_t seed = 1;                       ///< seed for choosing LODs and points inside triangles
};

struct AgainstReport {
  uint64_t triangles = 0;  ///< number of input triangles that are in exactly one leaf
  /// Number of input triangles that are degenerate on the lattice or belong to bad faces.
  uint64_t dropped = 0;
  uint64_t lods = 0;        ///< number of LODs measured
  uint64_t lods_below = 0;  ///< number of LODs with a stored error below the measured error
  double least_ratio = 0;   ///< smallest ratio of stored to measured error; at most 2
  double median_ratio = 0;
};

/// Compares a store with its input. Checks the invariants I1 and I4 of docs/architecture.md. I1: every input
/// triangle with three distinct lattice corners is in LOD 0 of exactly one leaf, with the same orientation
/// and attributes, and leaves contain no other triangles. I4: the stored error is at least the measured error
/// in 99 % of the LODs, and at least 0.8 times the measured error in every LOD. Skips bad values of the input
/// as --skip-bad does. Temporary files take about twice the bytes of the input's unindexed triangles
/// (soupBytes()).
/// @param progress  one thread at a time calls this function; an exception from it cancels the comparison.
/// @param witness  if the function throws because I4 is violated, receives a point that shows the violation.
/// @throws Error kInput or kIo (the input), kFormat (the first difference between store and input, with its
/// place).
AgainstReport compareWithInput(const AgainstOptions& options, const BuildProgress& progress = {},
                               std::optional<ErrorWitness>* witness = nullptr);

}  // namespace lode::ingest
