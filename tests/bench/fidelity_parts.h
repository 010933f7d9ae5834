#pragma once

#include <span>

namespace lode::bench {

/// The parts of bench_fidelity. Each prints one JSON object per measurement. @throws Error as
/// ingest::PlyReader.

/// Measures two-sided distances between cuts and their original. Compares cuts of the bunny with the
/// reference, too.
void compareCuts(const char* original, std::span<char* const> cuts);

/// Compares the triangle counts of cuts with those of meshoptimizer and collapse() on the whole model at the
/// same measured error.
void compareAtEqualError(const char* original, std::span<char* const> cuts);

/// Computes the peak signal-to-noise ratio of pairs of pictures where both show the model. The first of a
/// pair has full resolution. @param halvings  how often both pictures are halved before, in linear light.
void comparePictures(std::span<char* const> pairs, int halvings);

}  // namespace lode::bench
