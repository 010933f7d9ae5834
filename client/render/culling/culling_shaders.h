#pragma once

namespace lode::render {

/// Finds the clusters of each chunk that are in the view and that no depth hides; writes them as bits.
extern const char* const kFindShader;
/// Writes for each list the commands that draw the found clusters, in order, and their number.
extern const char* const kListShader;

}  // namespace lode::render
