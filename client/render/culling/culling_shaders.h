#pragma once

namespace lode::render {

/// Compute shader that tests the clusters of each chunk (see GpuCulling::Chunk) and writes one bit per
/// cluster. The bit is set if the cluster is in the view and not hidden behind the drawn depth.
extern const char* const kFindShader;
/// Compute shader that turns the bits of kFindShader into draw commands. For each list (see
/// GpuCulling::List), writes the commands in order and counts them.
extern const char* const kListShader;

}  // namespace lode::render
