#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/app/camera/camera_rig.h"
#include "client/app/window/flight.h"
#include "client/app/window/glfw_window.h"
#include "client/app/window/model_choices.h"
#include "client/app/window/output/picture_writer.h"
#include "client/app/window/pacing.h"
#include "client/app/window/panel/first_start.h"
#include "client/app/window/panel/panel.h"
#include "client/app/window/panel/panel_content.h"
#include "client/app/window/path_recorder.h"
#include "client/app/window/recent_targets.h"
#include "client/app/window/redraws.h"
#include "client/app/window/scene/picks.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/section_plane.h"
#include "client/app/window/settings.h"
#include "client/app/window/view_command.h"
#include "client/render/frame_timer.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/passes/ambient_occlusion.h"
#include "common/error.h"

namespace lode::app {

/// The program's window. Handles input, passes the camera to the streams, uploads within each frame's budget
/// and draws. Refinement, network and decoding run on the threads of each stream::Streamer. Use it only on
/// the main thread.
class Viewer {
 public:
  /// Opens the window and begins to open the target, or shows the start page if there is none. @throws Error.
  explicit Viewer(const ViewOptions& options);
  ~Viewer() { scene_.reset(); }  // destroys the scene before the window's OpenGL context
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  /// Runs until the user closes the window, or until --screenshot or --laps is done. Then writes the pending
  /// pictures, recording and kept measurements.
  /// @return false if the target could not be opened; the window and stderr have shown the reason.
  /// @throws Error on wrong usage, or if a pending file cannot be written. With --screenshot
  /// or --laps, also throws if the target cannot be opened. With --screenshot, throws if the picture is still
  /// incomplete at the timeout or when the window is closed. With --laps, throws if the flight cannot begin,
  /// or, after printing the frame times, if the flight ends early.
  bool run();

 private:
  using Clock = std::chrono::steady_clock;

  // The next functions are defined in viewer.cpp: the frame loop and drawing.
  static double secondsSince(Clock::time_point start);
  bool isInteractive() const;
  void frame();
  void passUnseen();
  void takeTimes();
  void stream();
  Difference difference(const Input& input) const;
  bool isAwaitingPicture() const;
  bool isWorthWaiting() const;
  render::DrawTime time() const;
  bool darkensHollows() const;
  bool isQuick() const;
  core::View drawnView() const;
  float drawnThresholdPx() const;
  const render::Framebuffer& target(const core::View& view);
  std::optional<render::Coarsening> coarseningOf(const render::DrawCounts& drawn,
                                                 const core::View& view) const;
  void draw();
  void describe();
  void describeWaiting();
  void noteFlight(std::optional<uint64_t> number);
  bool isMinimized() const;
  bool isLeaving() const;
  bool isTimeOver() const;
  double waitSeconds() const;
  bool settled() const;

  // The next functions are defined in viewer_opening.cpp. Adds the up axis that the user has chosen before,
  // unless the command line names one.
  static CommonOptions withUp(CommonOptions options, const std::string& up);
  ModelChoices keptChoices(const std::string& target) const;
  void fail(const Error& error);
  void openWhenReady();
  void openInstead(const std::string& file);
  void openChosen(const Input& input);
  void showStartPage(const std::string& message);

  // The next functions are defined in viewer_input.cpp: keys, mouse, camera and settings.
  void scrollPanel(Input& input);
  void obeyKeys(Input& input);
  void endMeasureOrLeave();
  void cut(const Input& input);
  void hideModels(const Input& input);
  void noteBookmark(const Input& input);
  void openOrCloseHelp(const Input& input);
  void pick(const Input& input);
  void pointAt(const Input& input);
  void snapPicks();
  void measure(const Input& input);
  std::optional<PickedPoint> under(const glm::dvec2& pixel_px);
  double coveredShare() const;
  void fly();
  std::optional<glm::dvec3> startOfWalk(const glm::dvec2& pointer_px, const GroundBelow& ground);
  void moveCamera(Input input, double seconds);
  Settings settings() const;
  void apply(const Settings& wanted);
  void setMemoryBudget(uint64_t budget_bytes);
  void keepChoices() const;
  void note(const std::string& message);
  void noteSaved(const std::string& file);

  // The next functions are defined in viewer_files.cpp: pictures and recorded camera paths.
  void record(const Input& input);
  void saveRecording();
  bool saveMeasures();
  void saveScreenshots();
  [[noreturn]] void refuseScreenshot() const;
  void noteWritten(const PictureWriter::Written& written);

  ViewOptions options_;
  ModelChoices choices_;
  std::optional<core::CameraPath> wanted_path_;
  std::unique_ptr<ViewedScene> scene_;  ///< never null; opens its first model while the window opens
  GlfwWindow window_;
  const bool draws_in_software_ = render::drawsInSoftware();
  const render::OcclusionCulling occlusion_culling_ = render::fastestOcclusionCulling();
  Panel panel_;
  /// Framebuffers: `smooth_` has several samples per pixel, `quick_` has one.
  std::optional<render::Framebuffer> smooth_, quick_;
  std::optional<render::AmbientOcclusion> occlusion_;  ///< created at the first use: linking is slow
  render::FrameTimer timer_;
  Pacing pacing_;
  double uploads_ms_ = 0;         ///< time spent on uploads since the last drawn frame
  std::optional<CameraRig> rig_;  ///< empty until the scene is open
  std::optional<Error> failed_;   ///< set if the scene cannot be opened
  /// State of the last picture drawn in the window.
  struct Drawn {
    core::View view;
    uint64_t serial = 0;
    bool is_quick = false;
    PanelContent content;
  };

  /// Camera changes that the user has chosen in the settings, for the next frame.
  struct Chosen {
    bool toggle_parallel = false;
    std::optional<core::Side> side;
  };

  Chosen chosen_;
  SectionPlane section_;
  Picks picks_;
  uint64_t snapped_serial_ = 0;  ///< ViewedScene::drawnSerial() when the picks were last snapped
  RefiningProgress progress_;
  const FirstStart first_start_;
  const RecentTargets recent_;
  const bool begins_at_start_page_ = options_.common.target.empty();
  PathRecorder recorder_;
  std::optional<Pilot> pilot_;  ///< set if --laps is given
  render::DrawStyle style_;
  ColorModeSwitch show_;
  size_t background_ = 0;  ///< index into kBackgrounds
  bool shows_scale_ = isInteractive();
  uint64_t memory_bytes_ = 0;
  bool fades_ = options_.common.fade;
  /// True to draw ambient occlusion. Off by default if the CPU draws, because a coarser threshold does not
  /// make ambient occlusion cheaper.
  bool darkens_hollows_ = !draws_in_software_;
  PanelContent content_;
  Clock::time_point started_ = Clock::now(), opened_ = started_, last_frame_ = started_, noted_ = started_;
  std::string note_;
  Drawn drawn_;
  Redraws redraws_;
  PictureRequest picture_request_;
  PictureWriter picture_writer_;
  int converged_frames_ = 0;
  bool moved_ = true, uploading_ = false, has_screenshot_ = false, done_ = false;
};

}  // namespace lode::app
