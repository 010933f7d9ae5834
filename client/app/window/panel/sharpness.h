#pragma once

#include <cstdint>
#include <string>

namespace lode::app {

/// Largest error that the panel shows. A larger value would be meaningless: the eye is then inside the box of
/// a cut part, and the part's surface may be anywhere in this box.
constexpr float kLargestToldErrorPx = 64;

/// State of a picture that is being refined.
struct Refining {
  float error_px = 0, threshold_px = 1;
  uint64_t tiles_to_come = 0;  ///< number of texture tiles that are still missing
  uint64_t received_bytes = 0;
};

// The functions below return the panel's texts about the error of the picture.

/// Returns the text for a picture that is being refined.
std::string refiningText(const Refining& refining);
/// Returns the text for a picture that lacks detail because of the memory budget.
std::string limitedText(float error_px);
/// Returns the text for a picture that lacks detail while the server is unreachable.
std::string waitingText(float error_px);
/// Describes a preview, which is shown while its store is built.
std::string previewText(float error_px);
/// Returns the text for a picture that lacks detail because finer parts are damaged or permanently refused.
std::string lackingText(float error_px);
/// Returns the text for a converged picture. An error above the threshold means that the file has no finer
/// triangles.
std::string convergedText(float error_px, float threshold_px);

}  // namespace lode::app
