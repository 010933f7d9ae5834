#pragma once

#include <span>

namespace lode::bench {

/// The parts of bench_fidelity. Each prints one JSON object per measurement. @throws Error as
/// ingest::PlyReader.

/// Two-sided distances of cuts from their original; of the bunny beside the reference, too.
void compareCuts(const char* original, std::span<char* const> cuts);

/// Triangles of cuts ÷ those of meshoptimizer and collapse() on the whole model at the same measured error.
void compareAtEqualError(const char* original, std::span<char* const> cuts);

/// Peak signal-to-noise ratio of pairs of pictures, full resolution first, where both show the model.
/// @param halvings  number of times that both are halved first, in linear light.
void comparePictures(std::span<char* const> pairs, int halvings);

}  // namespace lode::bench
