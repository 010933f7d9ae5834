#include "client/app/window/viewer.h"

/// What can be set with the mouse.
namespace lode::app {

Settings Viewer::settings() const {
  return {.unlit = show_.shown() == render::Show::kUnlit,
          .darkens_hollows = darkens_hollows_,
          .fades = fades_,
          .exposure = style_.exposure,
          .fixes_threshold = pacing_.isFixed(),
          .threshold_px = pacing_.thresholdPx(),
          .fps = static_cast<float>(pacing_.fps())};
}

/// What differs, so that what is beyond the reach of the settings stays.
void Viewer::apply(const Settings& wanted) {
  const Settings now = settings();
  if (wanted.unlit != now.unlit) show_.show(wanted.unlit ? render::Show::kUnlit : render::Show::kSurface);
  darkens_hollows_ = wanted.darkens_hollows;
  fades_ = wanted.fades;
  if (wanted.exposure != now.exposure) style_.exposure = wanted.exposure;
  if (wanted.fixes_threshold != now.fixes_threshold) pacing_.fix(wanted.fixes_threshold);
  if (wanted.threshold_px != now.threshold_px) pacing_.setThreshold(wanted.threshold_px);
  if (wanted.fps != now.fps) pacing_.setRate(wanted.fps);
}

}  // namespace lode::app
