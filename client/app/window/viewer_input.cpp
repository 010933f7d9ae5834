#include <algorithm>
#include <numbers>
#include <utility>

#include "client/app/cli/store_cache.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/panel/panel_font.h"
#include "client/app/window/panel/panel_layout.h"
#include "client/app/window/viewer.h"
#include "client/core/view/framing.h"
#include "client/render/residency/staging_ring.h"
#include "common/printable.h"
#include "common/up_axis.h"

/// Part of Viewer that handles input: keys, mouse, camera and settings.
namespace lode::app {
namespace {

constexpr double kLongestStepS = 0.1;  ///< longest time by which camera motion advances in one frame

}  // namespace

/// Uses the wheel to scroll the panel if the pointer is over a panel that is taller than the window.
void Viewer::scrollPanel(Input& input) {
  PanelScroll* const scroll = input.wheel != 0 ? panel_.scrolledAt(input.pointer_px) : nullptr;
  if (scroll == nullptr) return;
  scroll->turn(std::exchange(input.wheel, 0));
  input.over_panel = true;
}

void Viewer::obeyKeys(Input& input) {
  const Chosen chosen = std::exchange(chosen_, {});
  input.toggle_parallel = input.toggle_parallel != chosen.toggle_parallel;
  if (chosen.side) input.side = chosen.side;
  if (input.quit && !content_.help) endMeasureOrLeave();
  if (input.quit_where_idle && failed_) done_ = true;
  openOrCloseHelp(input);
  if (input.toggle_wireframe) show_.toggleWireframe();
  show_.step(input.next_show);
  for (int step = 0; step < input.next_clay; ++step) show_.nextClay();
  style_.show = show_.shown();
  style_.sun_turn_rad += input.light_px * (std::numbers::pi / std::max(1u, window_.heightPx()));
  if (input.reset_camera) style_.sun_turn_rad = {0, 0};
  if (scene_->hasFixedUp() && std::exchange(input.next_axis, 0) != 0)
    note("the scene's file sets the up axis");
  if (input.bookmark != 0) noteBookmark(input);
  if (input.toggle_panel) content_.visible = !content_.visible;
  if (input.toggle_settings) content_.shows_settings = !content_.shows_settings;
  if (input.toggle_messages) content_.shows_messages = !content_.shows_messages;
  if (input.toggle_full_screen) window_.toggleFullScreen();
  if (input.screenshot) picture_request_.ask(Clock::now());
  pacing_.sharpen(input.finer);
}

/// Ends the current measurement; closes the window if there is none.
void Viewer::endMeasureOrLeave() {
  if (picks_.current().points.empty()) {
    done_ = true;
  } else {
    picks_.clear();
    note("measurement ended; Esc leaves");
  }
}

/// Handles the keys and drags of the section plane.
void Viewer::cut(const Input& input) {
  const ModelSummary& summary = scene_->summary();
  const core::ModelBox box = core::toModelBox(summary.box, summary.lattice.step);
  for (int step = 0; step < input.next_section; ++step) section_.step(box);
  if (input.flip_section) section_.flip();
  section_.drag(input.section_px, rig_->view(), rig_->distanceModel(), box);
  style_.section = section_.section();
  if (input.next_section != 0 || input.flip_section || (section_.isOn() && input.section_px != glm::dvec2(0)))
    note(section_.describe(box));
}

/// Hides or isolates the model under the pointer; if there is none, shows all models.
void Viewer::hideModels(const Input& input) {
  if (!input.hide_model && !input.isolate_model) return;
  if (!scene_->hasFixedUp()) return note("only models of a scene can be hidden");
  const std::optional<PickedPoint> hit = under(input.pointer_px);
  if (!hit || hit->is_ground) {
    scene_->showAll();
    return note("all models are shown");
  }
  if (!(input.isolate_model ? scene_->isolate(hit->model_number) : scene_->hide(hit->model_number)))
    return note("no other model is shown; Z beside it: show all");
  note(hit->model + (input.isolate_model ? " is shown alone" : " is hidden") +
       "; Z beside the models: show all");
}

void Viewer::noteBookmark(const Input& input) {
  const std::string number = std::to_string(input.bookmark);
  if (input.set_bookmark)
    note("bookmark " + number + " set");
  else if (rig_ && !rig_->hasBookmark(input.bookmark))
    note("no bookmark " + number + " yet: Ctrl+" + number + " sets it");
}

/// Opens or closes the help. Any key closes it. After that, the help no longer opens on its own at program
/// start.
void Viewer::openOrCloseHelp(const Input& input) {
  if (!content_.help) {
    content_.help = input.toggle_help;
  } else if (input.any_key) {
    content_.help = false;
    first_start_.helpWasSeen();
  }
}

/// Returns the nearest point drawn at a pixel.
std::optional<PickedPoint> Viewer::under(const glm::dvec2& pixel_px) {
  return scene_->under(rig_->view(), pixel_px, style_.section);
}

/// Picks a point, handles the keys of measurements, then copies the picks if requested. Copies last, so that
/// the copy includes the input of the same frame.
void Viewer::pick(const Input& input) {
  if (input.pressed || input.clicked || input.double_clicked || input.wheel != 0) pointAt(input);
  measure(input);
  if (!input.copy) return;
  std::string text;
  for (const std::string& line : picks_.lines(rig_->up(), choices_.unit)) text += line + "\n";
  if (!text.empty()) window_.copyToClipboard(text);
  note(text.empty() ? "click on the model first" : "copied");
}

void Viewer::pointAt(const Input& input) {
  const std::optional<PickedPoint> hit = under(input.pressed ? input.pressed_px : input.pointer_px);
  if (!hit) {
    if (input.clicked) picks_.clear();
    return;
  }
  if (input.double_clicked) {
    rig_->flyTo(hit->position_model);
    if (!input.clicked) picks_.takeBack();  // undo the pick of the double click's first click
    return;
  }
  rig_->turnAbout(hit->position_model);
  if (input.clicked) picks_.add(*hit);
}

/// Moves the picks to the drawn surface where it has become finer.
void Viewer::snapPicks() {
  if (std::exchange(snapped_serial_, scene_->drawnSerial()) == scene_->drawnSerial()) return;
  for (Measure* const measure : picks_.measures())
    for (PickedPoint& point : measure->points)
      if (auto finer = scene_->snapped(rig_->view(), point)) point = *std::move(finer);
}

/// Keeps, drops and exports measurements, and switches to the next kind.
void Viewer::measure(const Input& input) {
  for (int step = 0; step < input.next_measure; ++step) picks_.nextKind();
  if (input.next_measure != 0) note("measures: " + std::string(nameOf(picks_.kind())));
  if (input.keep_measure)
    note(picks_.keep() ? "measurement kept; J saves all" : "click on the model first; Shift+K: next kind");
  if (input.drop_measure && !picks_.dropLast()) note("no measurement is kept");
  if (!input.save_measures) return;
  if (picks_.all().empty())
    note("no measurement: click on the model first");
  else
    saveMeasures();
}

/// Returns the share of the window's width that the panel covers. Returns 0 with --screenshot and --laps, so
/// that the camera frames the model as in `render`.
double Viewer::coveredShare() const {
  if (!isInteractive() || !content_.visible) return 0;
  const glm::vec2 window_px(window_.widthPx(), window_.heightPx());
  return app::coveredShare(window_px, kTextPx * static_cast<float>(window_.contentScale()));
}

/// Returns the point where a walk starts: the surface point under the pointer, else the surface point at the
/// centre of the picture, else the ground below the eye.
std::optional<glm::dvec3> Viewer::startOfWalk(const glm::dvec2& pointer_px, const GroundBelow& ground) {
  const core::View& view = rig_->view();
  for (const glm::dvec2& pixel_px : {pointer_px, glm::dvec2(view.width_px, view.height_px) / 2.0})
    if (const auto hit = under(pixel_px); hit && !hit->is_on_cut) return hit->position_model;
  if (const auto below = ground(view.eye_model)) return view.eye_model - below->depth_model * rig_->up();
  return std::nullopt;
}

void Viewer::moveCamera(Input input, double seconds) {
  const core::View before = rig_->view();
  const CameraKind kind_before = rig_->kind();
  const auto ground = [this](const glm::dvec3& point) -> std::optional<Ground> {
    return scene_->groundBelow(rig_->view(), point, rig_->up());
  };
  const bool would_change_projection =
      input.toggle_parallel || (input.next_camera != 0 && rig_->isParallel());
  if (recorder_.recording() && would_change_projection) {
    input.toggle_parallel = false;
    input.next_camera = 0;
    note("a recorded path has one projection; P ends the recording");
  }
  std::optional<glm::dvec3> start;
  if (input.next_camera != 0) start = startOfWalk(input.pointer_px, ground);
  rig_->apply(input, std::min(seconds, kLongestStepS), ground);
  if (start && rig_->kind() != kind_before) rig_->standAt(*start);
  moved_ = rig_->view() != before || rig_->isMoving();
  if (input.side) note(std::string(core::kSideNames[static_cast<size_t>(*input.side)]) + " view");
  if (input.toggle_parallel) note(rig_->isParallel() ? "parallel projection; N: perspective" : "perspective");
  if (input.next_axis == 0) return;
  choices_.up = nameOfAxis(rig_->up());
  keepChoices();
  note("up axis: " + choices_.up + ", kept for this model; U: next axis");
}

/// Keeps the user's choices about the model for the next time that it is opened.
void Viewer::keepChoices() const {
  if (isInteractive() && !scene_->hasFixedUp() && !options_.common.copied)
    KeptChoices(cacheFolder(), options_.common.target).keep(choices_);
}

void Viewer::fly() {
  if (!pilot_) return;
  const Pilot::State state = pilot_->fly(*scene_, isTimeOver(), *rig_);
  moved_ = moved_ || state != Pilot::State::kWaiting;
  done_ = done_ || state == Pilot::State::kOver;
}

Settings Viewer::settings() const {
  return {.unlit = show_.shown() == render::ColorMode::kUnlit,
          .darkens_hollows = darkens_hollows_,
          .fades = fades_,
          .exposure = style_.exposure,
          .fixes_threshold = pacing_.isFixed(),
          .threshold_px = pacing_.thresholdPx(),
          .fps = static_cast<float>(pacing_.fps()),
          .memory_bytes = memory_bytes_,
          .parallel = rig_ && rig_->isParallel(),
          .background = background_,
          .cap_colour = section_.colour(),
          .shows_scale = shows_scale_,
          .unit = unitNumber(choices_.unit)};
}

/// Applies the settings that the user has changed. Leaves the others, because the command line may have set
/// values outside the panel's range.
void Viewer::apply(const Settings& wanted) {
  const Settings now = settings();
  if (wanted.unlit != now.unlit)
    show_.show(wanted.unlit ? render::ColorMode::kUnlit : render::ColorMode::kSurface);
  darkens_hollows_ = wanted.darkens_hollows;
  fades_ = wanted.fades;
  if (wanted.exposure != now.exposure) style_.exposure = wanted.exposure;
  if (wanted.fixes_threshold != now.fixes_threshold) pacing_.fix(wanted.fixes_threshold);
  if (wanted.threshold_px != now.threshold_px) pacing_.setThreshold(wanted.threshold_px);
  if (wanted.fps != now.fps) pacing_.setRate(wanted.fps);
  chosen_.toggle_parallel = wanted.parallel != now.parallel;
  chosen_.side = wanted.side;
  shows_scale_ = wanted.shows_scale;
  section_.colour(wanted.cap_colour);
  if (wanted.background != now.background) {
    background_ = wanted.background;
    style_.background_top_srgb = kBackgrounds[background_].top_srgb;
    style_.background_bottom_srgb = kBackgrounds[background_].bottom_srgb;
    style_.hides_sky = background_ != 0;
  }
  if (wanted.unit != now.unit) {
    choices_.unit = kUnits[wanted.unit];
    keepChoices();
  }
  if (wanted.memory_bytes == now.memory_bytes) return;
  scene_->setMemory(wanted.memory_bytes);
  setMemoryBudget(wanted.memory_bytes);
}

void Viewer::setMemoryBudget(uint64_t budget_bytes) {
  memory_bytes_ = budget_bytes;
  const MemoryShares memory = shareMemory(budget_bytes);
  content_.resident_budget_bytes = memory.stream_bytes;
  content_.gpu_budget_bytes = memory.gpu.budget_bytes + memory.gpu.texture_budget_bytes +
                              render::StagingRing::kSegments *
                                  (uint64_t{memory.gpu.staging_bytes} + memory.gpu.texture_staging_bytes);
}

/// Names the saved file in the panel, or on stderr if the window is about to close.
void Viewer::noteSaved(const std::string& file) {
  note("saved " + file);
  if (isLeaving()) printOnOneLine("lodestream", note_);
}

void Viewer::note(const std::string& message) {
  note_ = message;
  noted_ = Clock::now();
}

}  // namespace lode::app
