#include "client/app/window/panel/sharpness.h"

#include <cstdio>

#include "common/byte_size.h"

namespace lode::app {
namespace {

std::string offBy(float error_px) {
  char text[64];
  std::snprintf(text, sizeof text, "at most %.2f px off where it is seen", static_cast<double>(error_px));
  return text;
}

}  // namespace

std::string refiningText(const Refining& refining) {
  if (refining.error_px > kLargestToldErrorPx)
    return "refining: " + describeBytes(refining.received_bytes) + " received";
  if (refining.error_px > refining.threshold_px) return "refining, " + offBy(refining.error_px);
  if (refining.tiles_to_come == 0) return offBy(refining.error_px) + "; the rest is loading";
  return "textures: " + std::to_string(refining.tiles_to_come) +
         (refining.tiles_to_come == 1 ? " tile" : " tiles") + " missing";
}

std::string limitedText(float error_px) {
  return error_px > kLargestToldErrorPx ? "coarse where it is nearest" : offBy(error_px);
}

std::string waitingText(float error_px) { return limitedText(error_px) + "; the rest waits for the server"; }

std::string previewText(float error_px) { return "preview, " + limitedText(error_px); }

std::string lackingText(float error_px) { return limitedText(error_px) + "; finer parts are not available"; }

std::string convergedText(float error_px, float threshold_px) {
  if (error_px <= threshold_px) return "converged, " + offBy(error_px);
  return "full detail: the nearest triangles are the file's own";
}

}  // namespace lode::app
