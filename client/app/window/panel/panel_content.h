#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/camera/cameras.h"
#include "client/app/window/panel/notice.h"
#include "client/app/window/panel/pick_marks.h"
#include "client/app/window/panel/scale_bar.h"
#include "client/app/window/panel/start_page.h"
#include "client/app/window/redraws.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/settings.h"
#include "client/render/passes/color_mode.h"

namespace lode::app {

/// Progress of refinement from the initial error to the threshold. The scale is logarithmic: each halving of
/// the error adds the same progress. Pure.
class RefiningProgress {
 public:
  /// Updates the progress.
  /// @param error_px, threshold_px  error of the newest cut, and threshold to reach, > 0.
  /// @param converged  true if no more detail will load for this view.
  /// @return 0 to 1; 1 only if converged.
  double update(float error_px, float threshold_px, bool converged) noexcept;

 private:
  float start_px_ = 0;  ///< largest error since the picture last converged
};

/// Everything that the panel shows.
struct PanelContent {
  std::string title;               ///< name of the model or the target
  std::optional<StartPage> start;  ///< set while there is no target; nothing else is then shown
  bool is_open = false;            ///< true if the model is open
  bool is_preview = false;         ///< true while a preview is shown in place of a store
  std::string waiting;             ///< step that the user waits for; empty if there is none
  double waited_s = 0;
  double waiting_part = -1;           ///< finished fraction of this step, 0 to 1; negative: unknown
  uint64_t triangles = 0, nodes = 0;  ///< numbers of drawn triangles and nodes
  uint64_t model_triangles = 0;
  core::EngineCounts counts;  ///< statistics of the scene's streams
  uint64_t resident_budget_bytes = 0, gpu_bytes = 0, gpu_budget_bytes = 0;
  bool textured = false;
  uint64_t gpu_tiles = 0;  ///< number of texture tiles on the GPU
  float threshold_px = 1, error_px = 0;
  float final_threshold_px = 1;  ///< threshold of a camera at rest; the first pictures may have a larger one
  /// Target frame time for which the threshold is raised; 0 if it is not raised or the camera is at rest.
  double target_ms = 0;
  double aimed_ms = 0;  ///< target frame time for a moving camera; 0: none
  double scale = 1;     ///< scale of the picture's width and height; thresholds are in scaled pixels
  bool converged = false;
  bool limited = false;             ///< the memory budget prevents more detail
  bool exhausted = false;           ///< the program is offline, and the cache has no more detail
  bool incomplete = false;          ///< parts of the view could not be loaded
  bool waiting_for_server = false;  ///< the connection is lost; the program reconnects
  double progress = 0;              ///< progress of refinement, see RefiningProgress
  std::string_view lost;            ///< text of lostSightText(); empty if the model is in sight
  double frame_ms = 0, upload_ms = 0;
  CameraKind camera = CameraKind::kOrbit;
  std::vector<std::string> pick;            ///< lines of text about the last picked point
  std::vector<PickMarks> marks;             ///< marks of measurements in the picture
  std::optional<ScaleMarks> scale_marks;    ///< scale bar and axes of the picture
  std::string_view show;                    ///< name of the colour mode
  std::vector<render::LegendEntry> legend;  ///< meanings of the colours in this mode
  std::string_view explanation;             ///< explanation of the colour mode, see render::ColorModeTraits
  std::string warning;                      ///< warnings of the builds, see warningOf()
  std::string hidden;                       ///< names of hidden models, see hiddenText()
  std::string missing;                      ///< missing models of the scene, see missingText()
  Notice notice;                            ///< state of the stream
  bool recording = false;                   ///< true while the camera path is recorded
  std::string message;                      ///< temporary message, for example the file name of a screenshot
  Settings settings;
  bool visible = true, help = false, shows_settings = false;
  bool shows_messages = false;  ///< true to show all warnings and missing models instead of one line of each

  bool operator==(const PanelContent&) const = default;
};

/// State of the viewer that describe() needs.
struct ViewState {
  bool is_settled = false;  ///< no more detail will load for the view
  bool is_offline = false;
};

/// Fills in the state and the statistics of a scene's streams, and its use of the GPU.
void describe(const ViewedScene& scene, const ViewState& state, PanelContent& content);

/// Returns how the panel's content differs from the drawn content. Ignores frame times and what the panel
/// does not show: network statistics once the picture has converged, and the waiting time beside a bar of
/// known progress.
Difference differenceOf(PanelContent now, const PanelContent& drawn);

}  // namespace lode::app
