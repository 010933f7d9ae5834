#pragma once

#include <cstdint>
#include <filesystem>

#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

/// Size of the model that writeTrialModel() wrote.
struct TrialModel {
  uint64_t vertices = 0;
  uint64_t faces = 0;
};

/// Writes a part of a model as a PLY file without texture images, to estimate the cost of the whole model.
/// Divides the input's faces into `stretches` equal ranges and writes a stretch of consecutive faces from the
/// middle of each range, with their vertices and attributes. Skips bad values. Keeps the stretches in memory
/// and reads the input twice.
/// @param faces      approximate number of faces in all stretches together; a model with fewer faces is
/// written as a whole.
/// @param stretches  number of stretches, from 1 to `faces`.
/// @throws Error kIo, kInput.
TrialModel writeTrialModel(const std::filesystem::path& input, uint64_t model_faces, uint64_t faces,
                           uint64_t stretches, const std::filesystem::path& output);

}  // namespace lode::ingest
