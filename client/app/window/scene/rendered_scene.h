#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/app/window/scene/scene_stage.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// The scene that `render` draws; a single model is a scene of one model. Each model gets an equal part of
/// the memory budget. All instances of a model share one stream and one renderer. Create, use and destroy the
/// object on the thread of its OpenGL context.
class RenderedScene {
 public:
  struct Picture {
    bool is_drawn = false;       ///< false if an instance has no converged cut, so that there is no picture
    bool has_converged = false;  ///< true if all instances have converged, see hasConverged()
    /// Status of the first instance that did not converge, else of the last instance.
    stream::StreamStatus status;
    float max_error_px = 0;    ///< largest error of all instances
    bool has_preview = false;  ///< true if a model is only a preview
    std::vector<render::LegendEntry> legend;
  };

  /// Builds the stores of PLY files, starts servers for local models, and waits until all models are open.
  /// @param announce  true to print the progress of builds; see resolveTarget(). @throws Error.
  RenderedScene(const CommonOptions& options, bool announce);
  ~RenderedScene();

  /// Returns the camera path of --camera, or else the default camera as a path with one key.
  const core::CameraPath& path() const { return path_; }
  /// Draws the scene from the camera at time `t` of the path. Draws the instances one after another, each as
  /// soon as it has converged. @throws Error; kLimit if a model does not fit into its GPU memory.
  Picture draw(double t, const render::Framebuffer& target, render::DrawStyle style);

 private:
  struct Model;
  void drawInstance(Model& model, const Placement& placement, const core::View& seen,
                    const render::Framebuffer& target, render::DrawStyle style, double t);

  const Scene scene_;
  const PictureSize size_;
  const float pixels_;
  const std::chrono::milliseconds timeout_;
  std::vector<std::unique_ptr<Model>> models_;
  std::optional<SceneStage> stage_;
  glm::dvec3 up_{0};
  core::CameraPath path_;
};

}  // namespace lode::app
