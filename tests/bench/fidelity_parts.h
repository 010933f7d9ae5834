#pragma once

#include <span>

namespace lode::bench {

/// The parts of bench_fidelity; each prints what it measures. @throws Error as ingest::PlyReader.

/// Two-sided distances of cuts from their original; of the bunny's beside the reference.
void compareCuts(const char* original, std::span<char* const> cuts);

/// The paper's operator on the bunny: the cuts nearest to the reference's counts.
void comparePaper(const char* original);

/// Triangles of cuts beside those of meshoptimizer on the whole model at the same measured error.
void compareAtEqualError(const char* original, std::span<char* const> cuts);

/// What attributes lose with and without their quadrics, at equal triangle counts.
void compareAttributes(std::span<char* const> models);

/// Hoppe's form of attribute quadrics beside Garland's and Heckbert's.
void compareForms(std::span<char* const> models);

/// Pictures in pairs, the full resolution's first: peak signal-to-noise ratio where both show the model.
/// @param halvings  how often they are halved before, in linear light.
void comparePictures(std::span<char* const> pairs, int halvings);

}  // namespace lode::bench
