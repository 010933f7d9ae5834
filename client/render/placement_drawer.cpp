#include "client/render/placement_drawer.h"

#include "client/render/renderer.h"

namespace lode::render {
namespace {

/// Fewer are drawn sooner than found to be hidden.
constexpr size_t kFewClusters = 64;

}  // namespace

DrawCounts PlacementDrawer::draw(std::span<const Placement> placements, const Framebuffer& target,
                                 const DrawTime& time) {
  if (placements.empty()) return {};
  if (time.hidden_parts == HiddenParts::kFoundOnGpu) return drawByGpu(placements, target, time);
  DrawCounts counts;
  size_t clusters = 0;
  for (const Placement& at : placements) {
    counts += at.renderer->drawPlace(at.place, at.view, target, at.style, time);
    clusters += at.renderer->clustersInPicture(at.place);
  }
  if (time.hidden_parts != HiddenParts::kReadBack) return counts;
  if (!depth_reader_) depth_reader_.emplace();
  const FarthestDepths drawn = clusters < kFewClusters ? FarthestDepths() : depth_reader_->read(target);
  for (const Placement& at : placements)
    counts += at.renderer->drawAppeared(at.place, at.view, target, at.style, drawn);
  return counts;
}

DrawCounts PlacementDrawer::drawByGpu(std::span<const Placement> placements, const Framebuffer& target,
                                      const DrawTime& time) {
  if (!culling_) culling_.emplace();
  DrawCounts counts;
  culling_->begin();
  for (const Placement& at : placements)
    counts += at.renderer->addPlace(at.place, at.view, at.style, time, *culling_);
  const auto drawFound = [&] {
    goOnWithPicture(target);
    for (const Placement& at : placements)
      counts.calls += at.renderer->drawFound(at.place, at.view, target, at.style, *culling_);
  };
  startPicture(target, placements.front().style);
  culling_->findUnhidden();
  drawFound();
  culling_->findAppeared(target);
  drawFound();
  counts.triangles = culling_->trianglesLately();
  return counts;
}

}  // namespace lode::render
