#pragma once

namespace lode::render {

/// Of each chunk the clusters that are in the picture and that no depth hides, as bits.
extern const char* const kFindShader;
/// Of each draw the commands that draw what was found, in order, and how many.
extern const char* const kListShader;

}  // namespace lode::render
