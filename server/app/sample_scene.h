#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace lode::app {

constexpr size_t kSampleSceneInstances = 120;

/// Writes three models and scene.json, which places them 120 times on a ground, into a new folder.
/// @param triangles  of each model at most. @return triangles of the three models.
/// @throws Error as ingest::writeSample(); kIo if the folder is there or cannot be made.
uint64_t writeSampleScene(const std::filesystem::path& folder, uint64_t triangles, uint64_t seed);

}  // namespace lode::app
