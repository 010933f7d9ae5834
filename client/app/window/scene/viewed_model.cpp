#include "client/app/window/scene/viewed_model.h"

#include <utility>

#include "client/app/window/camera/ground_below.h"
#include "client/app/window/memory_shares.h"
#include "client/core/lod/cut.h"

namespace lode::app {
namespace {

stream::StreamOptions streamOptionsOf(stream::StreamOptions options) {
  const render::MemoryShares memory = render::shareMemory(options.engine.memory_budget_bytes);
  options.engine.memory_budget_bytes = memory.stream_bytes;
  options.engine.refine.drawn_budget_bytes = memory.drawn_bytes;
  return options;
}

}  // namespace

ViewedModel::ViewedModel(Target target, const stream::StreamOptions& options, core::Framing framing,
                         std::chrono::milliseconds timeout)
    : renderer_(1, render::shareMemory(options.engine.memory_budget_bytes).gpu),
      opener_(std::move(target), streamOptionsOf(options), std::move(framing), timeout) {}

ViewerContent::Opening ViewedModel::open() {
  if (progress_.streamer != nullptr) return {"", -1, true, std::nullopt};
  progress_ = opener_.progress();
  if (progress_.streamer != nullptr) renderer_.setLatticeStep(progress_.model->lattice.step);
  return {progress_.phase, progress_.part, progress_.streamer != nullptr, progress_.error};
}

void ViewedModel::setMemory(uint64_t budget_bytes) {
  const render::MemoryShares memory = render::shareMemory(budget_bytes);
  progress_.streamer->setMemoryBudget(memory.stream_bytes, memory.drawn_bytes);
  renderer_.setMemory(memory.gpu);
}

void ViewedModel::look(const core::View& view, float threshold_px) {
  progress_.streamer->setView(view, threshold_px);
  status_ = progress_.streamer->status();
  if (status_.view_cuts) renderer_.show(status_.view_cuts);
  if (probe_ && probe_->cut() != renderer_.meshes().drawnCut()) probe_.reset();  // it keeps all of its meshes
}

void ViewedModel::uploadInRenderThread() {
  renderer_.uploadInRenderThread({});
  progress_.streamer->keep(renderer_.meshes().takeMixtures());
}

render::DrawCounts ViewedModel::draw(const core::View& view, const render::Framebuffer& target,
                                     render::DrawStyle style, const render::DrawTime& time) {
  return renderer_.draw(view, target, style, time);
}

double ViewedModel::drawnThresholdRad() const {
  const auto& cut = renderer_.meshes().drawnCut();
  return cut ? thresholdRad(*cut) : 0;
}

ViewerContent::GpuUse ViewedModel::gpuUse() const {
  return {renderer_.gpuBytes(), renderer_.textures().tileCount(), renderer_.textures().set() != nullptr};
}

/// Of what is drawn; null while that is nothing.
const core::CutProbe* ViewedModel::probe() {
  const auto& cut = renderer_.meshes().drawnCut();
  if (!cut) return nullptr;
  if (!probe_ || probe_->cut() != cut) probe_.emplace(cut, summary().lattice.step);
  return &*probe_;
}

std::optional<PickedPoint> ViewedModel::under(const core::View& view, const glm::dvec2& place_px) {
  if (probe() == nullptr) return std::nullopt;
  const auto hit = probe_->cast(core::rayThrough(view, place_px), core::shownParts(*probe_->cut(), view));
  if (!hit) return std::nullopt;
  return pointOf(*hit, summary(), *status_.cut);
}

std::optional<render::Ground> ViewedModel::groundBelow(const core::View& view, const glm::dvec3& point_model,
                                                       const glm::dvec3& up) {
  if (probe() == nullptr) return std::nullopt;
  return app::groundBelow(*probe_, view, point_model, up);
}

}  // namespace lode::app
