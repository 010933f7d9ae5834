#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace lode::app {

constexpr size_t kSampleSceneInstances = 120;

/// Writes three models and a scene.json with kSampleSceneInstances instances of them into a new folder.
/// @param triangles  maximum for each model. @return triangles of the three models together.
/// @throws Error as ingest::writeSample() does; kIo if the folder exists or cannot be created.
uint64_t writeSampleScene(const std::filesystem::path& folder, uint64_t triangles, uint64_t seed);

}  // namespace lode::app
