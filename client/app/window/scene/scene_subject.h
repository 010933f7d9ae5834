#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/app/window/scene/picture_subject.h"
#include "client/app/window/scene/scene_stage.h"

namespace lode::app {

/// A scene whose models are open: one stream and one renderer a model, which its instances share, and equal
/// parts of one memory budget. Its pictures are drawn instance by instance.
class SceneSubject : public PictureSubject {
 public:
  /// Starts servers for local models, builds those that are PLYs, and waits until all are open. @throws
  /// Error.
  SceneSubject(const CommonOptions& options, bool announce);
  ~SceneSubject() override;

  const core::CameraPath& path() const override { return path_; }
  Taken take(double t, const render::Framebuffer& target, render::DrawStyle style) override;

 private:
  struct Model;
  core::CameraPath framingPath(const CommonOptions& options) const;

  const Scene scene_;
  const PictureSize size_;
  const float pixels_;
  const std::chrono::milliseconds timeout_;
  std::vector<std::unique_ptr<Model>> models_;
  std::optional<SceneStage> stage_;
  core::CameraPath path_;
};

}  // namespace lode::app
