#pragma once

#include <vector>

#include "client/core/view/camera_path.h"
#include "client/render/framebuffer.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// One picture of it, as far as it has converged.
struct Taken {
  stream::StreamStatus status;  ///< of what has not converged; if all has, of the last
  bool is_finest = false;       ///< else there is no picture
  bool has_converged = false;   ///< as hasConverged() has it
  float max_error_px = 0;
  std::vector<render::LegendEntry> legend;
};

/// What render takes pictures of.
class PictureSubject {
 public:
  virtual ~PictureSubject() = default;
  virtual const core::CameraPath& path() const = 0;
  /// Waits for it to converge. @throws Error, also where the GPU has no room.
  virtual Taken take(double t, const render::Framebuffer& target, render::DrawStyle style) = 0;
};

}  // namespace lode::app
