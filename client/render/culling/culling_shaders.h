#pragma once

namespace lode::render {

/// Compute shader that finds the clusters of each chunk that are in the view and not hidden by the depths. It
/// writes one bit per cluster.
extern const char* const kFindShader;
/// Compute shader that writes, for each list, the commands that draw the found clusters in order, and the
/// number of commands.
extern const char* const kListShader;

}  // namespace lode::render
