#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/camera/walk_camera.h"
#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
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

/// Selects how to handle models that cannot be opened.
enum class MissingModels : uint8_t {
  kRefused,  ///< opening the scene fails
  kAllowed   ///< the scene is shown without these models
};

/// The scene in the window; a single model is a scene of one model. Each model has one stream and one
/// renderer, which all instances of the model share. Each instance has its own cut and culling. Each model
/// opens on its own thread. If a model's server is unreachable, the scene tries again every few seconds and
/// shows the model once it is open. Views and points are in the frame of summary(). Use it only on the
/// window's thread.
class ViewedScene {
 public:
  /// Reads the scene that the target names, and begins to open its first model. Without a target, the scene
  /// is empty and never opens. Needs no OpenGL. @throws Error.
  ViewedScene(const CommonOptions& options, MissingModels missing_models);
  ~ViewedScene();

  struct Opening {
    std::string phase = {};  ///< description for the user
    double part = -1;        ///< finished fraction of the phase, 0 to 1; negative: unknown
    bool is_open = false;
    std::optional<Error> error = std::nullopt;
  };
  /// Continues to open the scene, without waiting. Until the scene is open, do not call summary(), framing(),
  /// update(), under() or groundBelow().
  Opening open();
  /// Returns a summary of the scene as if it were one model: name, coordinate frame, extent and triangles.
  const ModelSummary& summary() const { return whole_; }
  /// A preview, which is shown while its store is built.
  struct Preview {
    std::string phase;  ///< description of the build for the user; empty after a failed build
    double part = -1;   ///< finished fraction of the build, 0 to 1; negative: unknown
  };
  /// Returns the first preview in the scene, if there is one.
  std::optional<Preview> preview() const;
  /// Returns the build warnings of all models.
  std::vector<std::string> warnings() const;
  /// Returns a line for each missing model, with the reason.
  std::vector<std::string> missing() const;
  /// Hides all instances of a model. Views, picks, the extent of the scene and the first camera leave out
  /// hidden models. A hidden model streams nothing and leaves its memory to the others.
  /// @param model_number  PickedPoint::model_number. @return false if no other model is shown.
  bool hide(size_t model_number);
  /// Hides all models but one. @return false for a single model.
  bool isolate(size_t model_number);
  /// Shows all models.
  void showAll();
  /// Returns the names of the hidden models.
  std::vector<std::string> hidden() const;
  /// Returns true if the scene comes from a scene file. Such a file fixes the up axis, which the user then
  /// cannot change.
  bool hasFixedUp() const noexcept { return !scene_.is_single_model; }
  /// Returns the framing for the first camera.
  core::Framing framing() const;

  /// Changes the total memory budget of all streams and GPU copies.
  void setMemory(uint64_t budget_bytes);
  /// Requests the LODs that a view needs, and passes the newest cuts to the renderers.
  void update(const core::View& view, float threshold_px);
  /// Returns the combined status of all streams for the view of the last update(); see sceneStatus().
  const stream::StreamStatus& status() const { return status_; }
  /// Uploads meshes and texture tiles within the upload budget of one frame.
  void uploadInRenderThread();
  /// Returns true if the newest cut of every model is on the GPU.
  bool upToDate() const;
  /// Returns true if a model's newest cut does not fit into its GPU memory.
  bool overBudget() const;
  /// Returns true if every model either is up to date or over budget.
  bool uploaded() const;

  /// Draws the scene. Before the scene is open, draws only the background.
  /// @param style  drawing style; its `up` is the scene's up axis.
  render::DrawCounts draw(const core::View& view, const render::Framebuffer& target, render::DrawStyle style,
                          const render::DrawTime& time);
  /// Returns the cut parts (client/core/lod/cut.h) in the last picture.
  std::span<const render::DrawItem> inPicture() const { return in_picture_; }
  /// Returns the threshold of the coarsest drawn cut, see core::thresholdRad(); 0 while no cut is drawn.
  double drawnThresholdRad() const;
  /// Returns a number that grows whenever the drawn cuts change.
  uint64_t drawnSerial() const;
  // Returns true while parts fade, so that the next picture differs from the last even without a new cut.
  bool fading() const;
  /// Returns true while the picture changes because colours depend on the age of parts.
  bool ageing() const;

  struct GpuUse {
    uint64_t bytes = 0, tiles = 0;
    bool textured = false;
  };
  GpuUse gpuUse() const;

  /// Returns the nearest point drawn at a pixel: of a surface, of the ground, or of a solid's cut.
  /// @param pixel_px  position in the picture, from the top left corner.
  /// @param section   plane that cuts the models open, in the frame of summary().
  std::optional<PickedPoint> under(const core::View& view, const glm::dvec2& pixel_px,
                                   const std::optional<render::Section>& section);
  /// Picks a point anew on the drawn surface. Returns nothing if the surface at the point is not finer than
  /// at the pick.
  std::optional<PickedPoint> snapped(const core::View& view, const PickedPoint& point);
  /// Returns the nearest drawn surface straight below a point. @param up  up direction, unit length.
  std::optional<Ground> groundBelow(const core::View& view, const glm::dvec3& point_model,
                                    const glm::dvec3& up);

 private:
  struct VisibleInstance {
    double distance = 0;  ///< distance from the eye to the instance's box, in the scene's units
    InstancedModel* model = nullptr;
    size_t instance = 0;  ///< index in InstancedModel::instances
  };

  std::unique_ptr<RetryingOpener> openerOf(size_t number) const;
  void openNext();
  Error errorOf(const InstancedModel& model) const;
  void setUp();
  static void rest(const InstancedModel& model);
  void setHidden(const std::function<bool(const InstancedModel&)>& is_hidden);
  void addLateModels();
  core::View withNear(const core::View& view) const;
  core::View inTrueCoordinates(const core::View& view) const;
  render::DrawStyle styleOf(const VisibleInstance& visible, render::DrawStyle style) const;
  std::optional<PickedPoint> groundUnder(const core::Ray& ray, double& distance) const;
  PickedPoint onCut(const PickedPoint& behind, const glm::dvec3& point_model) const;
  PickedPoint pointInScene(const InstancedModel& model, size_t instance, const core::Hit& hit) const;
  std::vector<VisibleInstance> visibleInstances(const core::View& view) const;
  void forgetInvisible(std::span<const VisibleInstance> visible);
  void mergeStatus(const core::View& view);
  void shareMemory();
  void applyShare(const InstancedModel& model);

  const Scene scene_;
  const CommonOptions options_;
  const MissingModels missing_models_;
  const core::Framing framing_;  ///< framing without a coarsest mesh, which framing() adds for a single model
  std::unique_ptr<RetryingOpener> first_opener_;  ///< opener of the first model, until it is in models_
  std::vector<std::unique_ptr<InstancedModel>> models_;
  SceneMemory memory_;
  uint64_t gpu_budget_bytes_ = 0;  ///< GPU budget for the meshes of all models
  /// Index of the model that uploads first in the next frame, modulo the number of models.
  size_t first_upload_ = 0;
  std::optional<SceneStage> stage_;  ///< empty until the scene is open
  render::InstanceDrawer instance_drawer_;
  std::optional<render::Renderer> background_renderer_;  ///< set once a scene without models was drawn
  ModelSummary whole_;
  stream::StreamStatus status_;
  std::vector<render::DrawItem> in_picture_;
};

}  // namespace lode::app
