#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/app/window/scene/instanced_model.h"
#include "client/app/window/scene/scene_memory.h"
#include "client/app/window/scene/scene_stage.h"
#include "client/app/window/scene/viewer_content.h"
#include "client/render/instance_drawer.h"

namespace lode::app {

/// A scene in the window: one stream and one renderer a model, which its places share; a cut and its culling
/// for each place. Models whose server is away come when it is there.
class ViewedScene : public ViewerContent {
 public:
  /// Reads the scene. @throws Error.
  ViewedScene(const CommonOptions& options, Lacking lacking);
  ~ViewedScene() override;

  Opening open() override;
  const ModelSummary& summary() const override { return whole_; }
  std::vector<std::string> warnings() const override;
  std::vector<std::string> missing() const override;
  bool saysWhatIsUp() const override { return true; }
  core::Framing framing() const override { return framing_; }
  void setMemory(uint64_t budget_bytes) override;
  void look(const core::View& view, float threshold_px) override;
  const stream::StreamStatus& status() const override { return status_; }
  void uploadInRenderThread() override;
  bool upToDate() const override;
  bool overBudget() const override;
  bool uploaded() const override;
  render::DrawCounts draw(const core::View& view, const render::Framebuffer& target, render::DrawStyle style,
                          const render::DrawTime& time) override;
  std::span<const render::DrawItem> inPicture() const override { return in_picture_; }
  double drawnThresholdRad() const override;
  uint64_t drawnSerial() const override;
  bool fading() const override;
  bool ageing() const override;
  GpuUse gpuUse() const override;
  std::optional<PickedPoint> under(const core::View& view, const glm::dvec2& place_px) override;
  std::optional<render::Ground> groundBelow(const core::View& view, const glm::dvec3& point_model,
                                            const glm::dvec3& up) override;

 private:
  /// A place in the picture.
  struct Standing {
    double distance = 0;  ///< from the eye, in the scene
    InstancedModel* model = nullptr;
    size_t instance = 0;  ///< of the model
  };

  void openNext();
  Error errorOf(const InstancedModel& model) const;
  void setUp();
  void takeLate();
  core::View inScene(const core::View& view) const;
  std::optional<double> distanceToGround(const core::Ray& ray) const;
  std::vector<Standing> inSight(const core::View& scene_view) const;
  void leaveOutAllBut(std::span<const Standing> seen);
  void mergeStatus(const core::View& view);
  void shareMemory();
  void giveMemory(const InstancedModel& model);

  const Scene scene_;
  const CommonOptions options_;
  const Lacking lacking_;
  core::Framing framing_;
  std::vector<std::unique_ptr<InstancedModel>> models_;
  SceneMemory memory_;
  uint64_t gpu_budget_bytes_ = 0;    ///< of meshes of all models
  size_t first_upload_ = 0;          ///< model that uploads first, by turns
  std::optional<SceneStage> stage_;  ///< once none is being waited for
  render::InstanceDrawer instance_drawer_;
  ModelSummary whole_;
  stream::StreamStatus status_;
  std::vector<render::DrawItem> in_picture_;
};

}  // namespace lode::app
