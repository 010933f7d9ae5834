#include "client/app/window/viewer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/app/cli/opened_target.h"
#include "client/app/cli/remedy_words.h"
#include "client/app/cli/store_cache.h"
#include "client/app/window/panel/notice.h"
#include "client/app/window/panel/scale_bar.h"
#include "client/app/window/panel/sharpness.h"
#include "common/error.h"

namespace lode::app {
namespace {

// Times to wait for input if nothing needs to be drawn, in seconds.
constexpr double kIdleWaitS = 0.25;       ///< if all streams are settled
constexpr double kStreamingWaitS = 0.01;  ///< if a stream is refining or the target is being opened
constexpr double kCoarserWaitS = 0.002;   ///< if a coarser cut is about to be drawn
constexpr double kFirstMeshWaitS = 0.2;   ///< longest time without a frame once the scene is open
constexpr double kFramesOfFade = 4;       ///< parts fade only if a fade takes at least this many frames
constexpr double kScaleBarPx = 150;       ///< longest scale bar on a standard display
constexpr double kNoteS = 6;              ///< time for which a note stays on the panel

}  // namespace

double Viewer::secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Viewer::Viewer(const ViewOptions& options)
    : options_(options),
      choices_(keptChoices(options.common.target)),
      wanted_path_(wantedPath(options.common)),
      scene_(
          std::make_unique<ViewedScene>(withUp(options.common, choices_.up),
                                        isInteractive() ? MissingModels::kAllowed : MissingModels::kRefused)),
      window_(options.common.size().width_px, options.common.size().height_px,
              options.common.target.empty() ? "Lodestream" : options.common.target + " - Lodestream"),
      panel_(window_.handle()),
      pacing_(
          {.threshold_px = options.common.pixels,
           .is_fixed = options.is_threshold_fixed,
           .fps = options.fps,
           .begin = draws_in_software_ ? FrameRateControl::Begin::kCoarse : FrameRateControl::Begin::kFine},
          Clock::now()),
      first_start_(cacheFolder()),
      recent_(cacheFolder()),
      style_(styleOf(options.look)),
      show_(style_.show) {
  content_.title = options.common.target;
  if (options.laps > 0) pilot_.emplace(options, wanted_path_);
  content_.help = isInteractive() && first_start_.isHelpDue();
  setMemoryBudget(options.common.streamOptions().engine.memory_budget_bytes);
  if (begins_at_start_page_) showStartPage("");
}

bool Viewer::run() {
  while (!isLeaving()) frame();
  if (picture_request_.isOpen() && !isMinimized()) draw();
  if (recorder_.recording()) saveRecording();
  if (picks_.hasUnsaved()) saveMeasures();
  while (const auto written = picture_writer_.waitAndTake()) noteWritten(*written);
  if (!options_.screenshot.empty() && !has_screenshot_)
    throw Error(ErrorCode::kTimeout, options_.common.target + ": the window was closed before the picture " +
                                         options_.screenshot +
                                         " was saved; leave it open until it closes by itself");
  if (!pilot_) return !failed_;
  timer_.wait();
  takeTimes();
  pilot_->print();
  return true;
}

bool Viewer::isInteractive() const { return options_.screenshot.empty() && options_.laps == 0; }

bool Viewer::isMinimized() const { return window_.widthPx() == 0 || window_.heightPx() == 0; }

bool Viewer::isLeaving() const { return done_ || window_.shouldClose(); }

/// Returns true if the final cut of the current view is on the GPU.
bool Viewer::settled() const {
  const stream::StreamStatus& status = scene_->status();
  return rig_ && status.settled && status.cut && status.cut->view == drawnView() &&
         status.cut->threshold_px == pacing_.askedPx() && scene_->uploaded();
}

/// Returns the time to wait for input, which is long while nothing changes and short while streams refine.
double Viewer::waitSeconds() const {
  if (isMinimized() || ((failed_ || content_.start) && redraws_.frames() == 0)) return kIdleWaitS;
  if (isWorthWaiting()) return kCoarserWaitS;
  if ((rig_ && moved_) || redraws_.frames() > 0 || uploading_ || scene_->fading()) return 0;
  return (settled() || scene_->status().ended) && !window_.hasGamepad() ? kIdleWaitS : kStreamingWaitS;
}

void Viewer::frame() {
  window_.cover(panel_.covered());
  window_.handleEvents(waitSeconds());
  const double seconds = secondsSince(last_frame_);
  last_frame_ = Clock::now();
  Input input = window_.takeInput();
  if (content_.start) {
    input = withoutTyping(input);
    content_.start->enter = input.enter;
  }
  scrollPanel(input);
  obeyKeys(input);
  openChosen(input);
  openWhenReady();
  if (const auto written = picture_writer_.take()) noteWritten(*written);
  if (isMinimized()) return passUnseen();
  if (rig_) {
    rig_->resize(window_.widthPx(), window_.heightPx());
    rig_->frameBeside(coveredShare());
    hideModels(input);
    cut(input);
    pick(input);
    moveCamera(input, seconds);
    fly();
    record(input);
    takeTimes();
    pacing_.step(seconds, moved_, Clock::now());
    stream();
    snapPicks();
  }
  describe();
  redraws_.add(difference(input), Clock::now());
  if (redraws_.frames() == 0 || isWorthWaiting()) return;
  redraws_.draw(Clock::now());
  draw();
}

/// Handles a frame while the window is minimized: draws nothing, but checks the timeout and continues the
/// flight.
void Viewer::passUnseen() {
  const bool is_picture_due = !options_.screenshot.empty() || (pilot_ && !pilot_->isUnderWay());
  if (is_picture_due && isTimeOver())
    throw Error(
        ErrorCode::kTimeout,
        options_.common.target + " gave no picture within --timeout: its window is minimized; leave it open");
  if (rig_) fly();
}

/// Returns how the next picture would differ from the last drawn one.
Difference Viewer::difference(const Input& input) const {
  using enum Difference;
  if (input.any() || input.damaged || uploading_ || scene_->fading()) return kPicture;
  if (rig_ && !options_.screenshot.empty()) return kPicture;  // count frames until the picture is due
  if (traitsOf(style_.show).shows_time && scene_->ageing()) return kPicture;
  const bool is_same_picture = scene_->drawnSerial() == drawn_.serial && isQuick() == drawn_.is_quick &&
                               (!rig_ || rig_->view() == drawn_.view);
  return is_same_picture ? differenceOf(content_, drawn_.content) : kPicture;
}

/// Returns true if the scene is open, but no mesh of it is on the GPU yet.
bool Viewer::isAwaitingPicture() const { return rig_ && drawnThresholdPx() == 0 && !scene_->status().ended; }

/// Returns true if drawing should wait, because the first mesh or a much coarser cut will arrive soon. Frames
/// of an empty view would delay the first picture.
bool Viewer::isWorthWaiting() const {
  if (isAwaitingPicture() && secondsSince(opened_) < kFirstMeshWaitS) return true;
  return rig_ && pacing_.isWorthWaiting(drawnThresholdPx(), scene_->uploaded(), Clock::now());
}

void Viewer::noteFlight(std::optional<uint64_t> number) {
  if (!pilot_ || !number) return;
  FlownFrame frame;
  frame.upload_ms = content_.upload_ms;
  frame.target_ms = pacing_.targetMs();
  frame.threshold_px = drawnThresholdPx();
  frame.scale = content_.scale;
  frame.triangles = content_.triangles;
  pilot_->draw(*number, frame);
}

/// Collects the times of earlier frames that the GPU has finished.
void Viewer::takeTimes() {
  while (const auto frame = timer_.take()) {
    const double work_ms = std::max(frame->cpu_ms, frame->gpu_ms);
    pacing_.measure(work_ms, frame->coarsening);
    if (pilot_) pilot_->finish(frame->number, work_ms);
  }
}

void Viewer::stream() {
  scene_->update(drawnView(), pacing_.askedPx());
  uploading_ = !scene_->uploaded();
  const Clock::time_point start = Clock::now();
  scene_->uploadInRenderThread();
  uploads_ms_ += secondsSince(start) * 1e3;
}

/// Returns the time of the next picture, and whether parts fade. Parts never fade in a screenshot.
render::DrawTime Viewer::time() const {
  const bool is_fast_enough = pacing_.workMs() * kFramesOfFade <= render::kFadeS * 1e3;
  return {secondsSince(started_), fades_ && is_fast_enough && options_.screenshot.empty(),
          occlusion_culling_};
}

/// Returns true if ambient occlusion is drawn. A screenshot always has it, like the pictures of `render`. A
/// section has none, because it would show the hollow behind the cut. Parallel projection has none, because
/// its depths are too similar to find edges.
bool Viewer::darkensHollows() const {
  return (darkens_hollows_ || !options_.screenshot.empty()) && !style_.section &&
         !(rig_ && rig_->isParallel());
}

/// Returns true if the next picture is drawn without antialiasing. While the CPU draws for a moving camera, a
/// finer threshold is worth more than antialiasing. Before the model is there, antialiasing would only delay
/// its first picture, because the driver compiles each shader again for a target with several samples.
bool Viewer::isQuick() const {
  return draws_in_software_ && (!rig_ || !pacing_.isResting()) && options_.screenshot.empty();
}

/// Returns the camera's view with the size of the drawn picture. Thresholds are in pixels of this picture.
core::View Viewer::drawnView() const {
  core::View view;
  if (rig_) view = rig_->view();
  const auto scaled = [scale = isQuick() ? pacing_.scale() : 1](uint32_t px) {
    return std::max<uint32_t>(1, static_cast<uint32_t>(std::lround(scale * px)));
  };
  view.width_px = scaled(window_.widthPx());
  view.height_px = scaled(window_.heightPx());
  return view;
}

/// Returns the threshold of the coarsest drawn cut, in pixels of the next picture; 0 while no cut is drawn.
float Viewer::drawnThresholdPx() const {
  return static_cast<float>(scene_->drawnThresholdRad() * focalPx(drawnView()));
}

const render::Framebuffer& Viewer::target(const core::View& view) {
  std::optional<render::Framebuffer>& target = isQuick() ? quick_ : smooth_;
  if (!target || target->widthPx() != view.width_px || target->heightPx() != view.height_px)
    target.emplace(view.width_px, view.height_px, isQuick() ? 1 : 4);
  return *target;
}

/// Returns the coarsening of a drawn frame for the frame-rate control, or nothing if the frame is not typical
/// of a moving camera.
std::optional<render::Coarsening> Viewer::coarseningOf(const render::DrawCounts& drawn,
                                                       const core::View& view) const {
  std::optional<render::Coarsening> coarsening = render::coarseningOf(drawn.shown, pacing_.thresholdPx());
  if (!coarsening || !draws_in_software_) return coarsening;
  if (!isQuick()) return std::nullopt;
  const double pixels = static_cast<double>(view.width_px) * view.height_px;
  coarsening->pixel_share = render::pixelShareInSoftware(drawn.triangles, pixels);
  coarsening->scale = pacing_.scale();
  return coarsening;
}

void Viewer::draw() {
  const Clock::time_point start = Clock::now();
  const core::View view = drawnView();
  const render::Framebuffer& target = this->target(view);
  const std::optional<uint64_t> number = timer_.begin();
  if (rig_) style_.up = rig_->up();
  const render::DrawCounts drawn = scene_->draw(view, target, style_, time());
  if (rig_ && darkensHollows() && !isQuick()) {
    if (!occlusion_) occlusion_.emplace();
    occlusion_->darken(target, rig_->view().fov_y_rad, style_.show);
  }
  target.resolve();
  target.copyTo(0, window_.widthPx(), window_.heightPx());
  content_.triangles = drawn.triangles;
  content_.nodes = drawn.nodes;
  content_.error_px = drawn.error_px;
  content_.legend =
      legendOf(style_.show, scene_->inPicture(), std::max(drawnThresholdPx(), kLeastThresholdPx));
  const std::optional<render::Coarsening> coarsening = coarseningOf(drawn, view);
  drawn_ = {rig_ ? rig_->view() : view, scene_->drawnSerial(), isQuick(), content_};
  pacing_.draw(coarsening, Clock::now());
  panel_.prepare(window_.contentScale(), content_);
  panel_.drawMarksOf(content_);
  saveScreenshots();
  panel_.drawWindows();
  if (const auto wanted = panel_.takeSettings()) apply(*wanted);
  content_.upload_ms = std::exchange(uploads_ms_, 0);
  content_.frame_ms = secondsSince(start) * 1e3 + content_.upload_ms;
  timer_.end(content_.frame_ms, coarsening);
  noteFlight(number);
  window_.swap();
}

void Viewer::describe() {
  app::describe(*scene_, {.is_settled = settled(), .is_offline = options_.common.offline}, content_);
  if (failed_) content_.notice = noticeOf(*failed_);
  const auto& cut = scene_->status().cut;
  content_.progress = cut ? progress_.update(cut->max_error_px, pacing_.askedPx(), content_.converged) : 0;
  if (rig_) {
    content_.model_triangles = scene_->summary().triangles;
    content_.missing = missingText(scene_->missing(), content_.shows_messages);
    content_.hidden = hiddenText(scene_->hidden());
    content_.warning = warningOf(scene_->warnings(), content_.shows_messages);
    describeWaiting();
  }
  content_.threshold_px = pacing_.askedPx();
  content_.aimed_ms = pacing_.targetMs();
  content_.target_ms = pacing_.asksForFinest() || !pacing_.isMoving() ? 0 : content_.aimed_ms;
  content_.final_threshold_px = pacing_.thresholdPx();
  content_.scale = isQuick() ? pacing_.scale() : 1;
  content_.camera = rig_ ? rig_->kind() : CameraKind::kOrbit;
  const glm::dvec3 up = rig_ ? rig_->up() : glm::dvec3(0, 1, 0);
  content_.pick = picks_.lines(up, choices_.unit);
  content_.lost = rig_
                      ? lostSightText(core::toModelBox(scene_->summary().box, scene_->summary().lattice.step),
                                      rig_->view())
                      : "";
  content_.marks.clear();
  for (const Measure* const measure : picks_.measures())
    if (rig_ && !measure->points.empty())
      content_.marks.push_back(marksOf(*measure, up, choices_.unit, rig_->view()));
  content_.scale_marks.reset();
  if (rig_ && shows_scale_) {
    content_.scale_marks = ScaleMarks{std::nullopt, axesInPicture(rig_->view())};
    if (rig_->kind() == CameraKind::kOrbit)  // other cameras have no distance for the scale bar
      content_.scale_marks->bar = scaleBarOf(rig_->view(), rig_->distanceModel(),
                                             kScaleBarPx * window_.contentScale(), choices_.unit);
  }
  content_.recording = recorder_.recording();
  content_.show = nameOf(style_.show);
  content_.explanation = traitsOf(style_.show).explanation;
  content_.settings = settings();
  content_.message = secondsSince(noted_) < kNoteS ? note_ : "";
}

/// Describes the step that the user waits for while the scene is open: the first picture, or the builds of
/// stores whose previews are shown.
void Viewer::describeWaiting() {
  const bool is_waiting = isAwaitingPicture();
  content_.waiting = is_waiting ? "Loading the first picture" : "";
  content_.waiting_part = -1;
  content_.waited_s = is_waiting ? secondsSince(started_) : 0;
  const std::optional<ViewedScene::Preview> preview = scene_->preview();
  content_.is_preview = preview.has_value();
  if (is_waiting || !preview || preview->phase.empty()) return;
  content_.waiting = previewText(content_.error_px) + "\n" + preview->phase;
  content_.waiting_part = preview->part;
}

/// Returns true if the time of --timeout has passed since the target was opened.
bool Viewer::isTimeOver() const { return rig_ && secondsSince(opened_) > options_.common.timeout_s; }

}  // namespace lode::app
