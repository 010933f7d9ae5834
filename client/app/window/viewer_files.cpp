#include <exception>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/app/cli/remedy_words.h"
#include "client/app/cli/stream_report.h"
#include "client/app/window/output/picture_file.h"
#include "client/app/window/viewer.h"
#include "client/render/gl/image.h"
#include "common/error.h"
#include "common/io/atomic_file.h"

/// Part of Viewer that writes files: pictures and recorded camera paths.
namespace lode::app {

void Viewer::record(const Input& input) {
  recorder_.add(secondsSince(started_), rig_->camera(), glm::degrees(rig_->view().fov_y_rad));
  if (!input.record) return;
  if (recorder_.recording()) return saveRecording();
  recorder_.start();
  rig_->holdFieldOfView(true);
}

/// Ends the recording and writes its file. While the window is open, shows a failure as a note in the panel.
/// While the window closes, throws the error instead, because nobody would read the note.
void Viewer::saveRecording() {
  if (rig_) rig_->holdFieldOfView(false);
  try {
    if (const std::optional<std::string> file = recorder_.save())
      noteSaved(*file + ", for render --frames and replay");
  } catch (const Error& error) {
    if (isLeaving()) throw;
    note(messageOf(error));
  }
}

/// Writes all measurements as CSV and JSON into the current folder. Shows a failure as saveRecording() does.
/// @return false if they cannot be written.
bool Viewer::saveMeasures() {
  const std::vector<Measure> measures = picks_.all();
  try {
    std::string name = timedName("measurements");
    for (int number = 2; std::filesystem::exists(name + ".csv") || std::filesystem::exists(name + ".json");
         ++number)
      name = timedName("measurements-" + std::to_string(number));
    const std::string csv = name + ".csv", json = name + ".json";
    for (const auto& [file, text] : {std::pair{csv, measuresAsCsv(measures, rig_->up(), choices_.unit)},
                                     {json, measuresAsJson(measures, rig_->up(), choices_.unit)}}) {
      AtomicFile output(file, {}, OutputName::kDerived);
      output.write(std::as_bytes(std::span(text)));
      output.commit();
    }
    picks_.markSaved();
    noteSaved(csv + " and .json");
    return true;
  } catch (const Error& error) {
    if (isLeaving()) throw;
    note(messageOf(error));
    return false;
  }
}

/// Saves the pictures that are due, without the panel. The picture of --screenshot is due once the cut has
/// converged and is at rest; the program exits after saving it. A picture requested by a key is due once the
/// window is at rest: see PictureRequest.
void Viewer::saveScreenshots() {
  if (!options_.screenshot.empty()) {
    converged_frames_ = content_.converged && pacing_.asksForFinest() ? converged_frames_ + 1 : 0;
    if (converged_frames_ > Redraws::kFramesToSettle) {
      render::writePng(options_.screenshot, window_.readBack());
      has_screenshot_ = done_ = true;
    } else if (!content_.converged && (scene_->status().ended || settled() || isTimeOver())) {
      refuseScreenshot();
    }
  }
  const bool is_at_rest =
      redraws_.frames() == 0 && (rig_ || failed_);  // no picture is due while the target is being opened
  if (picture_request_.take(is_at_rest || isLeaving(), Clock::now()))
    picture_writer_.write(timedName("png"), window_.readBack());
}

/// Throws an Error with the reason why the picture of --screenshot cannot be complete.
void Viewer::refuseScreenshot() const {
  if (scene_->overBudget())
    throw Error(ErrorCode::kLimit, options_.common.target +
                                       ": the GPU has no room for all of the screenshot; allow more with "
                                       "--memory-budget, or a larger error with --pixels");
  refuseUnconverged("the screenshot's view", scene_->status(), options_.common);
}

void Viewer::noteWritten(const PictureWriter::Written& written) {
  try {
    if (written.failure) std::rethrow_exception(written.failure);
    note("saved " + written.file.string());
  } catch (const Error& error) {
    if (isLeaving()) throw;
    note(messageOf(error));
  }
}

}  // namespace lode::app
