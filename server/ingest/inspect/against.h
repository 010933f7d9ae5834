#pragma once

#include <cstdint>
#include <filesystem>

#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

struct AgainstOptions {
  std::filesystem::path store, input;
  std::filesystem::path temporary_folder;  ///< empty: the system's
  uint64_t memory_bytes = 0;               ///< for sorting; 0: defaultMemoryBytes()
  unsigned threads = 0;                    ///< that read and measure; 0: one a core
  size_t lods = 0;                         ///< at most, that are measured, spread over the tree; 0: all
  uint64_t seed = 1;                       ///< of the choice of LODs and of points inside triangles
};

struct AgainstReport {
  uint64_t triangles = 0;   ///< of the input, each in exactly one leaf
  uint64_t dropped = 0;     ///< of the input: not distinct on the lattice, or of faces that are none or bad
  uint64_t lods = 0;        ///< measured
  uint64_t lods_below = 0;  ///< whose stored error is below what was found
  double least_ratio = 0;   ///< of stored to found error; those above 2 count as 2
  double median_ratio = 0;
};

/// Compares a store with the file that it was built of: every input triangle with three distinct lattice
/// corners is in exactly one leaf's LOD 0 with its orientation and attributes, and no other is there (I1);
/// the stored errors of LODs are at least what a closer look finds in 99 %, and never below 0.8 of it (I4).
/// Bad values of the input are skipped as --skip-bad does. Temporary files: about twice the soup.
/// @param progress  called on one thread at a time; what it throws ends the work.
/// @throws Error kInput or kIo (the input), kFormat (the first difference, with its place).
AgainstReport compareWithInput(const AgainstOptions& options, const BuildProgress& progress = {});

}  // namespace lode::ingest
