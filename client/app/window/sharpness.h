#pragma once

#include <cstdint>
#include <string>

namespace lode::app {

/// A larger bound tells nothing: the eye is inside a part's box, whose surface may be anywhere in it.
constexpr float kLargestToldErrorPx = 64;

/// State of a picture that is being refined.
struct Refining {
  float error_px = 0, threshold_px = 1;
  uint64_t tiles_to_come = 0;  ///< texture tiles still missing
  uint64_t received_bytes = 0;
};

// Texts for the panel that state the error of the picture.

/// The picture is being refined.
std::string refiningText(const Refining& refining);
/// The memory budget limits the picture.
std::string limitedText(float error_px);
/// The server is unreachable.
std::string waitingText(float error_px);
/// Finer parts are damaged or refused for good.
std::string lackingText(float error_px);
/// The picture has converged. An error above the threshold means that the file has no finer triangles.
std::string convergedText(float error_px, float threshold_px);

}  // namespace lode::app
