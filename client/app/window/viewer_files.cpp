#include <exception>

#include "client/app/window/output/refused_screenshot.h"
#include "client/app/window/output/timed_name.h"
#include "client/app/window/viewer.h"
#include "client/render/image.h"
#include "common/error.h"

/// What the window writes: pictures and recorded cameras.
namespace lode::app {

void Viewer::record(const Input& input) {
  recorder_.see(secondsSince(started_), rig_->camera(), glm::degrees(rig_->view().fov_y_rad));
  if (!input.record) return;
  if (recorder_.recording())
    saveRecording();
  else
    recorder_.start();
}

/// Whoever is leaving would not read a note.
void Viewer::saveRecording() {
  try {
    if (const std::optional<std::string> file = recorder_.save())
      note("saved " + *file + ", for render --frames and replay");
  } catch (const Error& error) {
    if (isLeaving()) throw;
    note(error.what());
  }
}

/// The one that the command line asks for ends the program, once the panel fits its last text; one asked for
/// by a key does not.
void Viewer::saveScreenshots() {
  if (!options_.screenshot.empty()) {
    converged_frames_ = content_.converged && pacing_.asksForFinest() ? converged_frames_ + 1 : 0;
    if (converged_frames_ > kFramesToSettle) {
      render::writePng(options_.screenshot, window_.readBack());
      is_screenshot_there_ = done_ = true;
    } else if (!content_.converged && (scene_.status().ended || settled() || isTimeOver())) {
      refuseScreenshot(scene_, options_.common);
    }
  }
  if (picture_request_.take(frames_to_draw_ == 0 || isLeaving(), Clock::now())) savePicture();
}

/// It takes longer to compress than to draw.
void Viewer::savePicture() { picture_writer_.write(timedName("png"), window_.readBack()); }

void Viewer::tellOfPicture(const PictureWriter::Written& written) {
  try {
    if (written.failure) std::rethrow_exception(written.failure);
    note("saved " + written.file.string());
  } catch (const Error& error) {
    if (isLeaving()) throw;
    note(error.what());
  }
}

}  // namespace lode::app
