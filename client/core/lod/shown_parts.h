#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"

namespace lode::core {

/// How many numbers partOf() knows: first the cut's parts, then those of its fallbacks.
inline size_t partCount(const Cut& cut) noexcept { return cut.parts.size() + cut.fallbacks.size(); }
inline const CutPart& partOf(const Cut& cut, size_t number) noexcept {
  return number < cut.parts.size() ? cut.parts[number] : cut.fallbacks[number - cut.parts.size()].part;
}

/// What to draw of a cut for a camera, wherever it has gone since: the cut's parts, but where it sees a place
/// that is left out the fallback, for all of its region. It covers what the camera sees, no place twice.
/// @return numbers for partOf(), depth first.
std::vector<uint32_t> shownParts(const Cut& cut, const View& view);

/// The largest error in the picture of a camera, wherever it has gone since, of what is drawn of a cut; 0 if
/// it sees none of it. @param shown  numbers for partOf().
float shownErrorPx(const Cut& cut, std::span<const uint32_t> shown, const View& view) noexcept;

/// Places that are left out of a cut, that a camera sees, and that nothing drawn covers.
/// @param shown  numbers for partOf() of what is drawn.
size_t countHoles(const Cut& cut, std::span<const uint32_t> shown, const View& view);

}  // namespace lode::core
