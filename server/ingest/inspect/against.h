#pragma once

#include <cstdint>
#include <filesystem>

namespace lode::ingest {

struct AgainstOptions {
  std::filesystem::path store, input;
  std::filesystem::path temporary_folder;  ///< empty: the system's
  uint64_t memory_bytes = 0;               ///< for sorting; 0: defaultMemoryBytes()
  size_t rungs = 200;                      ///< at most, that are sampled
  size_t samples = 20000;                  ///< points each way of a rung
  uint64_t seed = 1;                       ///< of the choice of rungs and points
};

struct AgainstReport {
  uint64_t triangles = 0;    ///< of the input, each in exactly one leaf
  uint64_t dropped = 0;      ///< of the input: not distinct on the lattice, or no faces
  uint64_t rungs = 0;        ///< sampled
  uint64_t rungs_below = 0;  ///< whose stored error is below what sampling found
  double least_ratio = 0;    ///< of stored to sampled error
  double median_ratio = 0;
};

/// Compares a store with the file that it was built of: every input triangle with three distinct lattice
/// corners is in exactly one leaf's rung 0 with its orientation and attributes, and no other is there (I1);
/// the stored errors of a seeded spread of rungs are at least what dense sampling finds in 99 %, and never
/// below 0.8 of it (I4). Bad values of the input are skipped as --skip-bad does. Temporary files: about twice
/// the soup.
/// @throws Error kInput or kIo (the input), kFormat (the first difference, with its place).
AgainstReport compareWithInput(const AgainstOptions& options);

}  // namespace lode::ingest
