#include "client/app/window/viewer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/app/cli/cache_folder.h"
#include "client/app/cli/opened_target.h"
#include "client/app/window/camera/lost_sight.h"
#include "common/error.h"
#include "common/one_line.h"

namespace lode::app {
namespace {

constexpr double kIdleWaitS = 0.25;       ///< between looks at a stream that has nothing left to do
constexpr double kCoarserWaitS = 0.002;   ///< between looks at a coarser cut that is on its way
constexpr double kStreamingWaitS = 0.01;  ///< between looks at one that has
constexpr double kFramesOfFade = 4;       ///< that it takes to look like one
constexpr double kNoteS = 6;              ///< how long a note stays on the panel

}  // namespace

double Viewer::secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Viewer::Viewer(const ViewOptions& options)
    : options_(options),
      wanted_path_(wantedPath(options.common)),
      window_(options.common.size().width_px, options.common.size().height_px,
              options.common.target + " - Lodestream"),
      panel_(window_.handle()),
      scene_(options.common, isForAPerson() ? MissingModels::kAllowed : MissingModels::kRefused),
      pacing_({.threshold_px = options.common.pixels,
               .is_fixed = options.is_threshold_fixed,
               .fps = options.fps,
               .begin = draws_in_software_ ? render::FrameRateControl::Begin::kCoarse
                                           : render::FrameRateControl::Begin::kFine},
              Clock::now()),
      first_start_(cacheFolder()),
      style_(styleOf(options.look)),
      show_(style_.show) {
  content_.title = options.common.target;
  if (options.laps > 0) pilot_.emplace(options, wanted_path_);
  content_.help = isForAPerson() && first_start_.isHelpDue();
  noteMemory(options.common.streamOptions().engine.memory_budget_bytes);
}

bool Viewer::run() {
  while (!isLeaving()) frame();
  if (picture_request_.isOpen() && !isMinimized()) draw();
  if (recorder_.recording()) saveRecording();
  while (const auto written = picture_writer_.waitAndTake()) tellOfPicture(*written);
  if (!options_.screenshot.empty() && !is_screenshot_there_)
    throw Error(ErrorCode::kTimeout, options_.common.target + ": the window was closed before the picture " +
                                         options_.screenshot + " was there; it ends by itself when it is");
  if (!pilot_) return !failed_;
  timer_.wait();
  takeTimes();
  pilot_->tell();
  return true;
}

bool Viewer::isForAPerson() const { return options_.screenshot.empty() && options_.laps == 0; }

bool Viewer::isMinimized() const { return window_.widthPx() == 0 || window_.heightPx() == 0; }

bool Viewer::isLeaving() const { return done_ || window_.shouldClose(); }

/// Nothing more will come for what is looked at now.
bool Viewer::settled() const {
  const stream::StreamStatus& status = scene_.status();
  return rig_ && status.settled && status.cut && status.cut->view == drawnView() &&
         status.cut->threshold_px == pacing_.askedPx() && scene_.uploaded();
}

/// Nothing is drawn anew while nothing changes; what streams in is looked for often.
double Viewer::waitSeconds() const {
  if (isMinimized() || (failed_ && frames_to_draw_ == 0)) return kIdleWaitS;
  if (isWorthWaiting()) return kCoarserWaitS;
  if (moved_ || frames_to_draw_ > 0 || uploading_ || scene_.fading()) return 0;
  return (settled() || scene_.status().ended) && !window_.hasGamepad() ? kIdleWaitS
                                                                                 : kStreamingWaitS;
}

void Viewer::frame() {
  window_.cover(panel_.covered());
  window_.handleEvents(waitSeconds());
  const double seconds = secondsSince(last_frame_);
  last_frame_ = Clock::now();
  Input input = window_.takeInput();
  scroll(input);
  obey(input);
  openWhenReady();
  if (const auto written = picture_writer_.take()) tellOfPicture(*written);
  if (isMinimized()) return passUnseen();
  if (rig_) {
    rig_->resize(window_.widthPx(), window_.heightPx());
    rig_->frameBeside(coveredShare());
    pick(input);
    moveCamera(input, seconds);
    fly();
    record(input);
    takeTimes();
    pacing_.step(seconds, moved_, Clock::now());
    stream();
  }
  describe();
  if (isPictureOld(input)) frames_to_draw_ = 1 + kFramesToSettle;
  if (frames_to_draw_ == 0 || isWorthWaiting()) return;
  --frames_to_draw_;
  draw();
}

/// Nothing is drawn, but time goes on.
void Viewer::passUnseen() {
  const bool is_picture_due = !options_.screenshot.empty() || (pilot_ && !pilot_->isUnderWay());
  if (is_picture_due && isTimeOver())
    throw Error(ErrorCode::kTimeout,
                options_.common.target +
                    " gave no picture within --timeout, as its window is minimized: leave that open");
  if (rig_) fly();
}

/// Something has changed that can be seen.
bool Viewer::isPictureOld(const Input& input) const {
  if (input.any() || input.damaged || uploading_ || scene_.fading() || !options_.screenshot.empty())
    return true;
  if (style_.show == render::ColorMode::kAges && scene_.ageing()) return true;
  return differ(content_, drawn_.content) || scene_.drawnSerial() != drawn_.serial ||
         isQuick() != drawn_.is_quick || (rig_ && rig_->view() != drawn_.view);
}

/// For all of a coarser cut, to draw it instead of what is there.
bool Viewer::isWorthWaiting() const {
  return rig_ && pacing_.isWorthWaiting(drawnThresholdPx(), scene_.uploaded(), Clock::now());
}

void Viewer::obey(Input& input) {
  if (input.quit && !content_.help) done_ = true;
  if (input.quit_where_idle && failed_) done_ = true;
  openOrCloseHelp(input);
  if (input.toggle_wireframe) show_.toggleWireframe();
  show_.step(input.next_show);
  style_.show = show_.shown();
  if (scene_.hasFixedUp() && std::exchange(input.next_axis, 0) != 0)
    note("a scene says which way is up");
  if (input.bookmark != 0) tellOfBookmark(input);
  if (input.toggle_panel) content_.visible = !content_.visible;
  if (input.toggle_settings) content_.shows_settings = !content_.shows_settings;
  if (input.screenshot) picture_request_.ask(Clock::now());
  pacing_.sharpen(input.finer);
}

void Viewer::tellOfBookmark(const Input& input) {
  const std::string number = std::to_string(input.bookmark);
  if (input.set_bookmark)
    note("bookmark " + number + " is here");
  else if (rig_ && !rig_->hasBookmark(input.bookmark))
    note("no bookmark " + number + " yet: Ctrl+" + number + " sets it");
}

/// It goes with the next key, whatever that does, and is not shown by itself any more.
void Viewer::openOrCloseHelp(const Input& input) {
  if (!content_.help) {
    content_.help = input.toggle_help;
  } else if (input.any_key) {
    content_.help = false;
    first_start_.helpWasSeen();
  }
}

/// Who started the window from no terminal reads there why nothing comes, until it is closed.
void Viewer::fail(const Error& error) {
  if (!isForAPerson() || error.code() == ErrorCode::kUsage) throw error;
  failed_ = error;
  sayOnOneLine("lodestream", error.what());
  content_.waiting.clear();
  content_.help = false;
}

void Viewer::openWhenReady() {
  if (rig_ || failed_) return;
  const ViewedScene::Opening opening = scene_.open();
  if (opening.error) return fail(*opening.error);
  content_.waiting = opening.phase;
  content_.waiting_part = opening.part;
  content_.waited_s = secondsSince(started_);
  if (!opening.is_open) return;
  const ModelSummary& summary = scene_.summary();
  opened_ = Clock::now();
  content_.is_open = true;
  core::Framing framing = scene_.framing();
  framing.covered = coveredShare();
  rig_.emplace(summary, framing, wanted_path_, window_.widthPx(), window_.heightPx());
  content_.title = summary.name;
  content_.warning = warningOf(scene_.warnings());
  for (const std::string& model : scene_.missing())
    sayOnOneLine("lodestream", options_.common.target + ": " + model);
  window_.setTitle(summary.name + " - Lodestream");
}

/// What is drawn at a place.
std::optional<PickedPoint> Viewer::under(const glm::dvec2& place_px) {
  return scene_.under(rig_->view(), place_px);
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

/// What was clicked on in the same frame is copied, too.
void Viewer::pick(const Input& input) {
  if (input.pressed || input.clicked || input.double_clicked || input.wheel != 0) pointAt(input);
  if (!input.copy) return;
  std::string text;
  for (const std::string& line : picks_.lines()) text += line + "\n";
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
    if (!input.clicked) picks_.takeBack();  // what the first of the two clicks added
    return;
  }
  rig_->turnAbout(hit->position_model);
  if (input.clicked) picks_.add(*hit);
}

/// Those of frames that were drawn some frames ago.
void Viewer::takeTimes() {
  while (const auto frame = timer_.take()) {
    const double work_ms = std::max(frame->cpu_ms, frame->gpu_ms);
    pacing_.measure(work_ms, frame->coarsening);
    if (pilot_) pilot_->finish(frame->number, work_ms);
  }
}

void Viewer::stream() {
  scene_.update(drawnView(), pacing_.askedPx());
  uploading_ = !scene_.uploaded();
  const Clock::time_point start = Clock::now();
  scene_.uploadInRenderThread();
  uploads_ms_ += secondsSince(start) * 1e3;
}

/// A screenshot shows the model alone.
render::DrawTime Viewer::time() const {
  const bool is_fast_enough = pacing_.workMs() * kFramesOfFade <= render::kFadeS * 1e3;
  return {secondsSince(started_), fades_ && is_fast_enough && options_.screenshot.empty(), hidden_parts_};
}

/// A screenshot is the picture that `render` draws.
bool Viewer::darkensHollows() const { return darkens_hollows_ || !options_.screenshot.empty(); }

/// Where the processor draws, samples of pixels cost time that is better spent on a finer threshold while the
/// camera moves.
bool Viewer::isQuick() const {
  return draws_in_software_ && rig_ && !pacing_.isResting() && options_.screenshot.empty();
}

/// The camera's, with the pixels that are really drawn: thresholds are in these.
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

/// In the pixels of the next picture; 0 while nothing is drawn.
float Viewer::drawnThresholdPx() const {
  return static_cast<float>(scene_.drawnThresholdRad() * focalPx(drawnView()));
}

const render::Framebuffer& Viewer::target(const core::View& view) {
  std::optional<render::Framebuffer>& target = isQuick() ? quick_ : smooth_;
  if (!target || target->widthPx() != view.width_px || target->heightPx() != view.height_px)
    target.emplace(view.width_px, view.height_px, isQuick() ? 1 : 4);
  return *target;
}

/// What the frame tells of those while the camera moves: nothing, where it is drawn in another way.
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
  const render::DrawCounts drawn = scene_.draw(view, target, style_, time());
  if (rig_ && darkensHollows() && !isQuick()) occlusion_.darken(target, rig_->view().fov_y_rad, style_.show);
  target.resolve();
  target.copyTo(0, window_.widthPx(), window_.heightPx());
  content_.triangles = drawn.triangles;
  content_.nodes = drawn.nodes;
  content_.error_px = drawn.error_px;
  content_.legend =
      legendOf(style_.show, scene_.inPicture(), std::max(drawnThresholdPx(), kLeastThresholdPx));
  const std::optional<render::Coarsening> coarsening = coarseningOf(drawn, view);
  drawn_ = {rig_ ? rig_->view() : view, scene_.drawnSerial(), isQuick(), content_};
  pacing_.draw(coarsening, Clock::now());
  panel_.prepare(window_.contentScale(), content_);
  panel_.draw(content_);
  if (const auto wanted = panel_.takeSettings()) apply(*wanted);
  saveScreenshots();
  content_.upload_ms = std::exchange(uploads_ms_, 0);
  content_.frame_ms = secondsSince(start) * 1e3 + content_.upload_ms;
  timer_.end(content_.frame_ms, coarsening);
  noteFlight(number);
  window_.swap();
}

void Viewer::describe() {
  app::describe(scene_, {.is_settled = settled(), .is_offline = options_.common.offline}, content_);
  if (failed_) content_.notice = noticeOf(*failed_);
  const auto& cut = scene_.status().cut;
  content_.progress = cut ? progress_.see(cut->max_error_px, pacing_.askedPx(), content_.converged) : 0;
  if (rig_) {
    content_.model_triangles = scene_.summary().triangles;
    content_.missing = missingText(scene_.missing());
    const bool is_waiting = drawnThresholdPx() == 0 && !scene_.status().ended;
    content_.waiting = is_waiting ? "Loading the first picture" : "";
    content_.waiting_part = -1;
    content_.waited_s = is_waiting ? secondsSince(started_) : 0;
  }
  content_.threshold_px = pacing_.askedPx();
  content_.aimed_ms = pacing_.targetMs();
  content_.target_ms = pacing_.asksForFinest() ? 0 : content_.aimed_ms;
  content_.scale = isQuick() ? pacing_.scale() : 1;
  content_.camera = rig_ ? rig_->kind() : CameraKind::kOrbit;
  content_.pick = picks_.lines();
  content_.lost = rig_ ? lostSightText(core::toModelBox(scene_.summary().box,
                                                        scene_.summary().lattice.step),
                                       rig_->view())
                       : "";
  content_.marks = rig_ ? marksOf(picks_, rig_->view()) : PickMarks();
  content_.recording = recorder_.recording();
  content_.show = nameOf(style_.show);
  content_.explanation = explanationOf(style_.show);
  content_.settings = settings();
  content_.message = secondsSince(noted_) < kNoteS ? note_ : "";
}

void Viewer::note(const std::string& message) {
  note_ = message;
  noted_ = Clock::now();
}

/// That --timeout allows from when the target was open.
bool Viewer::isTimeOver() const { return rig_ && secondsSince(opened_) > options_.common.timeout_s; }

}  // namespace lode::app
