#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/app/window/camera/camera_kind.h"
#include "client/app/window/panel/notice.h"
#include "client/app/window/panel/pick_marks.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/settings.h"
#include "client/render/shown_colours.h"

namespace lode::app {

/// What the panel shows.
struct PanelContent {
  std::string title;     ///< of the model or the target
  bool is_open = false;  ///< there are figures of it
  std::string waiting;   ///< what is being waited for; empty once the model is open
  double waited_s = 0;
  double waiting_part = -1;           ///< of it that is done, 0 to 1; below: unknown
  uint64_t triangles = 0, nodes = 0;  ///< drawn
  uint64_t model_triangles = 0;
  uint64_t received_bytes = 0;
  double link_bytes_per_s = 0, round_trip_ms = 0;  ///< 0: not measured yet
  core::RequestCounts requests;                    ///< that are open
  uint64_t resident_bytes = 0, resident_budget_bytes = 0, gpu_bytes = 0, gpu_budget_bytes = 0;
  bool textured = false;
  uint64_t tiles = 0, tiles_left_out = 0;  ///< of textures: on the GPU, and those that memory does not allow
  float threshold_px = 1, error_px = 0;
  double target_ms = 0;  ///< of a frame, for which the threshold is coarser than asked for; 0: it is not
  double aimed_ms = 0;   ///< what a frame may take while the camera moves; 0: whatever it does
  double scale = 1;      ///< of the picture's sides: fewer pixels, in which thresholds are
  bool converged = false;
  bool limited = false;             ///< memory allows no more of what is seen
  bool exhausted = false;           ///< offline: the cache has no more of what is seen
  bool lacking = false;             ///< what would make it finer cannot be had
  bool waiting_for_server = false;  ///< which has gone away
  double progress = 0;              ///< towards that, 0 to 1
  std::string_view lost;            ///< see lostSightText()
  double frame_ms = 0, upload_ms = 0;
  CameraKind camera = CameraKind::kOrbit;
  std::vector<std::string> pick;            ///< of the point last clicked on
  PickMarks marks;                          ///< of it and the one before, in the picture
  std::string_view show;                    ///< what the picture shows,
  std::vector<render::LegendEntry> legend;  ///< and what its colours mean
  std::string_view explanation;             ///< of it, where colours do not explain it
  std::string warning;                      ///< of a build
  std::string missing;                      ///< models of a scene
  Notice notice;                            ///< how the stream fares
  bool recording = false;                   ///< the camera's path
  std::string message;                      ///< for a moment, such as where a screenshot went
  Settings settings;
  bool visible = true, help = false, shows_settings = false;

  bool operator==(const PanelContent&) const = default;
};

/// How a scene is looked at.
struct Looked {
  bool is_settled = false;  ///< nothing more will come for the view
  bool is_offline = false;
};

/// Says what a scene's stream has brought, what of it is on the GPU, and how it fares.
void describe(const ViewedScene& scene, const Looked& looked, PanelContent& content);

/// They differ in what is worth a new picture: in more than what the last frame took and, at rest, bytes that
/// only keep the connection.
bool differ(PanelContent now, const PanelContent& drawn);

}  // namespace lode::app
