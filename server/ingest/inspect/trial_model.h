#pragma once

#include <cstdint>
#include <filesystem>

#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

/// How much of a model was written.
struct TrialModel {
  uint64_t vertices = 0;
  uint64_t faces = 0;
};

/// Writes stretches of a model's faces, each from the middle of an equal part of the file, with their
/// vertices and attributes, as a PLY without textures: what a build of it costs says what the whole will. Bad
/// values are skipped. Takes memory for the stretches, and reads the file twice.
/// @param faces      of all stretches, about; the whole model if it has fewer.
/// @param stretches  at least 1, and not more than faces.
/// @throws Error kIo, kInput.
TrialModel writeTrialModel(const std::filesystem::path& input, uint64_t model_faces, uint64_t faces,
                           uint64_t stretches, const std::filesystem::path& output);

}  // namespace lode::ingest
