#pragma once

#include <optional>

#include "client/app/window/scene/model_opener.h"
#include "client/app/window/scene/viewer_content.h"
#include "client/core/lod/cut_probe.h"

namespace lode::app {

/// One model in the window.
class ViewedModel : public ViewerContent {
 public:
  /// Begins to open the target. @param memory_budget_bytes  of the stream and the GPU together. @throws
  /// Error.
  ViewedModel(Target target, const stream::StreamOptions& options, core::Framing framing,
              std::chrono::milliseconds timeout);

  Opening open() override;
  const ModelSummary& summary() const override { return *progress_.model; }
  std::vector<std::string> warnings() const override { return progress_.warnings; }
  core::Framing framing() const override { return progress_.framing; }
  void setMemory(uint64_t budget_bytes) override;
  void look(const core::View& view, float threshold_px) override;
  const stream::StreamStatus& status() const override { return status_; }
  void uploadInRenderThread() override;
  bool upToDate() const override { return renderer_.upToDate(); }
  bool overBudget() const override { return renderer_.meshes().overBudget(); }
  bool uploaded() const override { return upToDate() || overBudget(); }
  render::DrawCounts draw(const core::View& view, const render::Framebuffer& target, render::DrawStyle style,
                          const render::DrawTime& time) override;
  std::span<const render::DrawItem> inPicture() const override { return renderer_.inPicture(); }
  double drawnThresholdRad() const override;
  uint64_t drawnSerial() const override { return renderer_.meshes().drawnSerial(); }
  bool fading() const override { return renderer_.fading(); }
  bool ageing() const override { return renderer_.ageing(); }
  GpuUse gpuUse() const override;
  std::optional<PickedPoint> under(const core::View& view, const glm::dvec2& place_px) override;
  std::optional<render::Ground> groundBelow(const core::View& view, const glm::dvec3& point_model,
                                            const glm::dvec3& up) override;

 private:
  const core::CutProbe* probe();

  render::Renderer renderer_;
  ModelOpener opener_;
  ModelOpener::Progress progress_;  ///< the last
  stream::StreamStatus status_;
  std::optional<core::CutProbe> probe_;  ///< of the cut last clicked or walked on
};

}  // namespace lode::app
