#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "client/core/view/view.h"
#include "client/render/culling/depth_reader.h"
#include "client/render/culling/gpu_culling.h"
#include "client/render/draw_counts.h"
#include "client/render/draw_style.h"
#include "client/render/passes/cross_fade.h"

namespace lode::render {

class Renderer;

/// A model where it stands once.
struct InstanceDraw {
  Renderer* renderer = nullptr;
  size_t instance = 0;  ///< of the model
  core::View view;      ///< as the model sees it from there
  DrawStyle style{};
};

/// Draws models where they stand, and leaves out what they hide of one another. Made, used and destroyed on
/// the thread of its context.
class InstanceDrawer {
 public:
  /// @param instances  those in sight, best the nearest first; styles of all but the first are over what is
  ///                    there. Renderer::leaveOut() is for all others.
  DrawCounts draw(std::span<const InstanceDraw> instances, const Framebuffer& target, const DrawTime& time);

 private:
  DrawCounts drawByGpu(std::span<const InstanceDraw> instances, const Framebuffer& target,
                       const DrawTime& time);

  std::optional<DepthReader> depth_reader_;
  std::optional<GpuCulling> culling_;
};

}  // namespace lode::render
