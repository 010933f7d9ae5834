#include "client/app/window/sharpness.h"

#include <cstdio>

namespace lode::app {
namespace {

std::string offBy(float error_px) {
  char text[64];
  std::snprintf(text, sizeof text, "at most %.2f px off where it is seen", static_cast<double>(error_px));
  return text;
}

}  // namespace

std::string refiningText(float error_px) {
  return error_px > kLargestToldErrorPx ? "refining" : "refining, " + offBy(error_px);
}

std::string limitedText(float error_px) {
  return error_px > kLargestToldErrorPx ? "coarse where it is nearest" : offBy(error_px);
}

std::string convergedText(float error_px, float threshold_px) {
  if (error_px <= threshold_px) return "converged, " + offBy(error_px);
  return "all the detail there is: the nearest triangles are the file's own";
}

}  // namespace lode::app
