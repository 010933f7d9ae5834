#include "client/render/instance_drawer.h"

#include "client/render/renderer.h"

namespace lode::render {
namespace {

/// With fewer clusters than this, reading depth back costs more than drawing hidden clusters.
constexpr size_t kFewClusters = 64;

}  // namespace

DrawCounts InstanceDrawer::draw(std::span<const InstanceDraw> instances, const Framebuffer& target,
                                const DrawTime& time) {
  if (instances.empty()) return {};
  if (time.occlusion_culling == OcclusionCulling::kOnGpu) return drawByGpu(instances, target, time);
  DrawCounts counts;
  size_t clusters = 0;
  for (const InstanceDraw& at : instances) {
    counts += at.renderer->drawInstance(at.instance, at.view, target, at.style, time);
    clusters += at.renderer->clustersInPicture(at.instance);
  }
  if (time.occlusion_culling != OcclusionCulling::kReadBack) return counts;
  if (!depth_reader_) depth_reader_.emplace();
  const FarthestDepths drawn = clusters < kFewClusters ? FarthestDepths() : depth_reader_->read(target);
  for (const InstanceDraw& at : instances)
    counts += at.renderer->drawAppeared(at.instance, at.view, target, at.style, drawn);
  return counts;
}

DrawCounts InstanceDrawer::drawByGpu(std::span<const InstanceDraw> instances, const Framebuffer& target,
                                     const DrawTime& time) {
  if (!culling_) culling_.emplace();
  DrawCounts counts;
  culling_->begin();
  for (const InstanceDraw& at : instances)
    counts += at.renderer->addInstance(at.instance, at.view, at.style, time, *culling_);
  const auto drawFound = [&] {
    continuePicture(target);
    for (const InstanceDraw& at : instances)
      counts.calls += at.renderer->drawFound(at.instance, at.view, target, at.style, *culling_);
  };
  startPicture(target, instances.front().style);
  culling_->findUnhidden();
  drawFound();
  culling_->findAppeared(target);
  drawFound();
  counts.triangles = culling_->trianglesLately();
  return counts;
}

}  // namespace lode::render
