#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/app/window/camera/walk_camera.h"
#include "client/app/window/scene/instanced_model.h"
#include "client/app/window/scene/picks.h"
#include "client/app/window/scene/scene_memory.h"
#include "client/app/window/scene/scene_stage.h"
#include "client/core/view/framing.h"
#include "client/core/view/view.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/instance_drawer.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"
#include "common/error.h"

namespace lode::app {

/// Whether a scene may be shown without models that cannot be opened.
enum class MissingModels : uint8_t { kRefused, kAllowed };

/// The scene in the window; a single model is a scene of one. Each model has one stream and one renderer,
/// which its instances share; each instance has its own cut and culling. Models open on threads of their own.
/// A model whose server is unreachable is opened again every few seconds and appears when it is open. Views
/// and points are in the frame of summary(). For the window's thread.
class ViewedScene {
 public:
  /// Reads the scene that the target names. @throws Error.
  ViewedScene(const CommonOptions& options, MissingModels missing_models);
  ~ViewedScene();

  struct Opening {
    std::string phase = {};  ///< for the user
    double part = -1;        ///< finished part of the phase, 0 to 1; below 0: unknown
    bool is_open = false;
    std::optional<Error> error = std::nullopt;
  };
  /// Advances the opening, without waiting. Until it is open there is no summary() and framing(), and views
  /// must not be passed to update(), under() and groundBelow().
  Opening open();
  /// Describes the scene as one model: its name, frame, extent and triangles.
  const ModelSummary& summary() const { return whole_; }
  /// Returns the warnings of its models' builds.
  std::vector<std::string> warnings() const;
  /// Returns a line for each missing model, with the reason.
  std::vector<std::string> missing() const;
  /// Returns true if a scene's file says which axis is up: the user cannot turn it.
  bool hasFixedUp() const noexcept { return !scene_.is_single_model; }
  /// Returns how the first camera frames it.
  core::Framing framing() const;

  /// Changes the memory budget of all streams and GPU copies together.
  void setMemory(uint64_t budget_bytes);
  /// Requests the LODs that a camera needs, and takes the newest cuts.
  void update(const core::View& view, float threshold_px);
  /// Status of all streams together for the view last updated; see sceneStatus(). Its cut has no parts.
  const stream::StreamStatus& status() const { return status_; }
  /// Uploads within one frame's budget.
  void uploadInRenderThread();
  /// Returns true if the newest cut of every model is on the GPU.
  bool upToDate() const;
  /// Returns true if a model's newest cut does not fit into its GPU memory.
  bool overBudget() const;
  /// Returns true if every model either is up to date or over budget.
  bool uploaded() const;

  /// Before the scene is open it draws the background alone. @param style  `up` is the scene's up axis.
  render::DrawCounts draw(const core::View& view, const render::Framebuffer& target, render::DrawStyle style,
                          const render::DrawTime& time);
  /// Parts in the last picture.
  std::span<const render::DrawItem> inPicture() const { return in_picture_; }
  /// Threshold of the coarsest cut that is drawn, see core::thresholdRad(); 0 while none is.
  double drawnThresholdRad() const;
  /// Grows with each cut that becomes the drawn one.
  uint64_t drawnSerial() const;
  /// Returns true if the next picture differs from the last although no cut has arrived: parts fade, or
  /// colours by age change.
  bool fading() const;
  bool ageing() const;

  struct GpuUse {
    uint64_t bytes = 0, tiles = 0;
    bool textured = false;
  };
  GpuUse gpuUse() const;

  /// Returns the nearest surface point drawn at a pixel. @param pixel_px  from the picture's top left corner.
  std::optional<PickedPoint> under(const core::View& view, const glm::dvec2& pixel_px);
  /// Returns the nearest drawn surface straight below a point. @param up  unit length.
  std::optional<Ground> groundBelow(const core::View& view, const glm::dvec3& point_model,
                                    const glm::dvec3& up);

 private:
  struct VisibleInstance {
    double distance = 0;  ///< eye to the nearest point of its box, in the scene's units
    InstancedModel* model = nullptr;
    size_t instance = 0;  ///< index in InstancedModel::instances
  };

  void openNext();
  Error errorOf(const InstancedModel& model) const;
  void setUp();
  void addLateModels();
  core::View withNear(const core::View& view) const;
  core::View inTrueCoordinates(const core::View& view) const;
  render::DrawStyle styleOf(const VisibleInstance& visible, render::DrawStyle style) const;
  std::optional<PickedPoint> groundUnder(const core::Ray& ray, double& distance) const;
  std::vector<VisibleInstance> visibleInstances(const core::View& view) const;
  void forgetInvisible(std::span<const VisibleInstance> visible);
  void mergeStatus(const core::View& view);
  void shareMemory();
  void applyShare(const InstancedModel& model);

  const Scene scene_;
  const CommonOptions options_;
  const MissingModels missing_models_;
  const core::Framing framing_;  ///< a single model adds its coarsest mesh
  std::vector<std::unique_ptr<InstancedModel>> models_;
  SceneMemory memory_;
  uint64_t gpu_budget_bytes_ = 0;    ///< for the meshes of all models
  size_t first_upload_ = 0;          ///< model that uploads first in the next frame
  std::optional<SceneStage> stage_;  ///< empty until the scene is open
  render::InstanceDrawer instance_drawer_;
  ModelSummary whole_;
  stream::StreamStatus status_;
  std::vector<render::DrawItem> in_picture_;
};

}  // namespace lode::app
