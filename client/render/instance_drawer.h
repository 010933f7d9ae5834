#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "client/core/view/view.h"
#include "client/render/culling/depth_pyramid.h"
#include "client/render/culling/gpu_culling.h"
#include "client/render/draw_counts.h"
#include "client/render/passes/cross_fade.h"
#include "client/render/passes/draw_style.h"

namespace lode::render {

class Renderer;

/// One instance of a model to draw.
struct InstanceDraw {
  Renderer* renderer = nullptr;
  size_t instance = 0;  ///< index among the model's instances
  core::View view;      ///< view in the instance's model frame
  DrawStyle style{};
};

/// Draws instances of models into one picture, with occlusion culling across all instances. Create, use and
/// destroy the object on the thread of its OpenGL context.
class InstanceDrawer {
 public:
  /// @param instances  the visible instances, preferably nearest first. All styles except the first must set
  ///                   DrawStyle::over. Call Renderer::leaveOut() for instances that are not drawn.
  DrawCounts draw(std::span<const InstanceDraw> instances, const Framebuffer& target, const DrawTime& time);

 private:
  DrawCounts drawByGpu(std::span<const InstanceDraw> instances, const Framebuffer& target,
                       const DrawTime& time);

  std::optional<DepthReader> depth_reader_;
  std::optional<GpuCulling> culling_;
};

}  // namespace lode::render
