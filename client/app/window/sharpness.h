#pragma once

#include <string>

namespace lode::app {

/// A bound beyond it says nothing: the eye is in a part's box, and the part may be anywhere in it.
constexpr float kLargestToldErrorPx = 64;

/// For people, how far a picture may be off: of one that becomes finer,
std::string refiningText(float error_px);
/// of one that memory keeps from that,
std::string limitedText(float error_px);
/// and of one that has converged. Above the threshold that is so only where the file has no more.
std::string convergedText(float error_px, float threshold_px);

}  // namespace lode::app
