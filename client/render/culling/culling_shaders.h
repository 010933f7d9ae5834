#pragma once

namespace lode::render {

/// Compute shader that writes one bit per cluster of each chunk. The bit is set if the cluster is in the view
/// and the depths do not hide it.
extern const char* const kFindShader;
/// Compute shader that writes the commands of each list, in order, and their number. The commands draw the
/// clusters that kFindShader found.
extern const char* const kListShader;

}  // namespace lode::render
