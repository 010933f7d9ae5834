#include <memory>
#include <string>
#include <utility>

#include "client/app/cli/remedy_words.h"
#include "client/app/cli/store_cache.h"
#include "client/app/cli/target.h"
#include "client/app/window/viewer.h"
#include "common/printable.h"

/// Part of Viewer that opens targets.
namespace lode::app {

CommonOptions Viewer::withUp(CommonOptions options, const std::string& up) {
  if (options.up_text.empty()) options.up_text = up;
  return options;
}

/// Returns the user's earlier choices about a model. Returns none for scenes, whose files set the up axis,
/// and none with --screenshot or --laps, so that other users get the same result.
ModelChoices Viewer::keptChoices(const std::string& target) const {
  if (!isInteractive() || namesScene(target) || target.empty()) return {};
  return KeptChoices(cacheFolder(), target).read();
}

/// Shows the error in the window, which stays open because the user may have no terminal. If the window began
/// with the start page, shows the error there. With --screenshot or --laps, and on wrong usage, throws the
/// error instead.
void Viewer::fail(const Error& error) {
  if (!isInteractive() || error.code() == ErrorCode::kUsage) throw error;
  printOnOneLine("lodestream", messageOf(error));
  if (begins_at_start_page_) return showStartPage(messageOf(error));
  failed_ = error;
  content_.waiting.clear();
  content_.help = false;
}

void Viewer::openWhenReady() {
  if (rig_ || failed_) return;
  const ViewedScene::Opening opening = scene_->open();
  if (opening.error) return fail(*opening.error);
  content_.waiting = opening.phase;
  content_.waiting_part = opening.part;
  content_.waited_s = secondsSince(started_);
  if (!opening.is_open) return;
  const ModelSummary& summary = scene_->summary();
  opened_ = Clock::now();
  content_.is_open = true;
  core::Framing framing = scene_->framing();
  framing.covered = coveredShare();
  rig_.emplace(summary, framing, wanted_path_, window_.widthPx(), window_.heightPx());
  content_.title = summary.name;
  for (const std::string& model : scene_->missing())
    printOnOneLine("lodestream", options_.common.target + ": " + model);
  window_.setTitle(summary.name + " - Lodestream");
  if (isInteractive() && !options_.common.copied) recent_.add(options_.common.target);
}

/// Opens a file that was dropped on the window, or that the user has chosen on the start page.
void Viewer::openChosen(const Input& input) {
  const std::string chosen = panel_.takeTarget();
  const std::string& target = input.dropped.empty() ? chosen : input.dropped;
  if (!target.empty() && isInteractive()) openInstead(target);
}

/// Opens a file in place of the scene. If the file is no target, or if kept measurements cannot be saved,
/// shows the reason and keeps the scene. Drops the camera path, up axis and offline mode of the previous
/// target.
void Viewer::openInstead(const std::string& file) {
  CommonOptions common = options_.common;
  common.target = file;
  common.camera_file.clear();
  common.up_text.clear();
  common.offline = false;
  common.copied.reset();
  common.memory_text = std::to_string(memory_bytes_);  // the settings may have changed the budget
  const ModelChoices choices = keptChoices(file);
  std::unique_ptr<ViewedScene> scene;
  try {
    scene = std::make_unique<ViewedScene>(withUp(common, choices.up), MissingModels::kAllowed);
  } catch (const Error& error) {
    if (content_.start)
      content_.start->message = messageOf(error);
    else
      note(messageOf(error));
    return;
  }
  if (picks_.hasUnsaved() && !saveMeasures()) return;
  if (recorder_.recording()) saveRecording();
  rig_.reset();  // refers to the scene
  scene_ = std::move(scene);
  options_.common = std::move(common);
  choices_ = choices;
  wanted_path_.reset();
  failed_.reset();
  picks_ = {};
  section_ = {};
  progress_ = {};
  drawn_ = {};
  uploading_ = false;
  started_ = opened_ = Clock::now();
  PanelContent content;
  content.title = file;
  content.help = content_.start && first_start_.isHelpDue();
  content.visible = content_.visible;
  content.shows_settings = content_.shows_settings;
  content.shows_messages = content_.shows_messages;
  content_ = std::move(content);
  setMemoryBudget(memory_bytes_);
  window_.setTitle(file + " - Lodestream");
}

/// Shows the start page in place of the scene. @param message  reason why the last target could not be
/// opened.
void Viewer::showStartPage(const std::string& message) {
  rig_.reset();  // refers to the scene
  options_.common.target.clear();
  scene_ = std::make_unique<ViewedScene>(options_.common, MissingModels::kAllowed);
  drawn_ = {};
  uploading_ = false;
  content_ = {};
  content_.start.emplace();
  content_.start->message = message;
  for (const std::string& target : recent_.read())
    content_.start->recent.push_back({target, isMissing(target)});
  setMemoryBudget(memory_bytes_);
  window_.setTitle("Lodestream");
}

}  // namespace lode::app
