#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/app/window/camera/camera_rig.h"
#include "client/app/window/camera/path_recorder.h"
#include "client/app/window/camera/pilot.h"
#include "client/app/window/color_mode_switch.h"
#include "client/app/window/glfw_window.h"
#include "client/app/window/output/picture_request.h"
#include "client/app/window/output/picture_writer.h"
#include "client/app/window/pacing.h"
#include "client/app/window/panel/first_start.h"
#include "client/app/window/panel/panel.h"
#include "client/app/window/panel/refining_progress.h"
#include "client/app/window/scene/picks.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/view_options.h"
#include "client/render/frame_timer.h"
#include "client/render/framebuffer.h"
#include "client/render/passes/ambient_occlusion.h"
#include "common/error.h"

namespace lode::app {

/// The window: takes input, tells the stream what is looked at, uploads within each frame's budget and draws.
/// Refinement, network and decoding happen on the threads of the stream::Streamer. For the program's first
/// thread.
class Viewer {
 public:
  /// Opens the window and begins to open the target. @throws Error.
  explicit Viewer(const ViewOptions& options);
  /// Returns when the user closes the window; a picture that a key has asked for, and what was recorded, is
  /// written before.
  /// @return false if the target could not be opened: why is on a line of stderr, and was in the window.
  /// @throws Error where nobody looks at the window (--screenshot, --laps) or wrong usage is why it could
  /// not, if the screenshot asked for is not to be had in time or not there when the window is closed, that
  /// last picture cannot be written, or the flight asked for cannot begin or is not over: what was flown of
  /// it is printed before.
  bool run();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kFramesToSettle = 2;  ///< that the panel takes to fit its text

  static double secondsSince(Clock::time_point start);
  bool isForAPerson() const;
  void frame();
  void passUnseen();
  void fail(const Error& error);
  void openWhenReady();
  void obey(Input& input);
  void scroll(Input& input);
  void tellOfBookmark(const Input& input);
  void openOrCloseHelp(const Input& input);
  void pick(const Input& input);
  void pointAt(const Input& input);
  void record(const Input& input);
  void saveRecording();
  std::optional<PickedPoint> under(const glm::dvec2& place_px);
  double coveredShare() const;
  void fly();
  void noteFlight(std::optional<uint64_t> number);
  std::optional<glm::dvec3> startOfWalk(const glm::dvec2& pointer_px, const render::GroundBelow& ground);
  void moveCamera(const Input& input, double seconds);
  void takeTimes();
  void stream();
  bool isPictureOld(const Input& input) const;
  bool isWorthWaiting() const;
  render::DrawTime time() const;
  bool darkensHollows() const;
  Settings settings() const;
  void apply(const Settings& wanted);
  void noteMemory(uint64_t budget_bytes);
  bool isQuick() const;
  core::View drawnView() const;
  float drawnThresholdPx() const;
  const render::Framebuffer& target(const core::View& view);
  std::optional<render::Coarsening> coarseningOf(const render::DrawCounts& drawn,
                                                 const core::View& view) const;
  void draw();
  void describe();
  bool isMinimized() const;
  bool isLeaving() const;
  void saveScreenshots();
  void savePicture();
  void tellOfPicture(const PictureWriter::Written& written);
  void note(const std::string& message);
  bool isTimeOver() const;
  double waitSeconds() const;
  bool settled() const;

  const ViewOptions options_;
  const std::optional<core::CameraPath> wanted_path_;
  GlfwWindow window_;
  const bool draws_in_software_ = render::drawsInSoftware();
  const render::HiddenParts hidden_parts_ = render::fastestHiddenParts();
  Panel panel_;
  ViewedScene scene_;
  std::optional<render::Framebuffer> smooth_, quick_;  ///< of several samples a pixel, and of one
  render::AmbientOcclusion occlusion_;
  render::FrameTimer timer_;
  Pacing pacing_;
  double uploads_ms_ = 0;         ///< since the last frame
  std::optional<CameraRig> rig_;  ///< once it is open
  std::optional<Error> failed_;   ///< why it cannot be
  /// What the picture in the window was drawn from.
  struct Drawn {
    core::View view;
    uint64_t serial = 0;
    bool is_quick = false;
    PanelContent content;
  };

  Picks picks_;
  RefiningProgress progress_;
  const FirstStart first_start_;
  PathRecorder recorder_;
  std::optional<Pilot> pilot_;  ///< of --laps
  render::DrawStyle style_;
  ColorModeSwitch show_;
  uint64_t memory_bytes_ = 0;
  bool fades_ = options_.common.fade;
  /// It costs about as much in every frame, which no threshold makes up for where the processor draws.
  bool darkens_hollows_ = !draws_in_software_;
  PanelContent content_;
  Clock::time_point started_ = Clock::now(), opened_ = started_, last_frame_ = started_, noted_ = started_;
  std::string note_;
  Drawn drawn_;
  PictureRequest picture_request_;
  PictureWriter picture_writer_;
  int frames_to_draw_ = 0, converged_frames_ = 0;
  bool moved_ = true, uploading_ = false, is_screenshot_there_ = false, done_ = false;
};

}  // namespace lode::app
