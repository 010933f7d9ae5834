#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/app/window/picture_subject.h"
#include "client/render/memory_shares.h"

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
  static constexpr uint64_t kBackdropBytes = 1u << 20;  ///< of two triangles
  struct Model;
  core::CameraPath framingPath(const CommonOptions& options) const;
  void makeGround();
  void drawGround(const core::View& view, const render::Framebuffer& target, const render::DrawStyle& style);

  const Scene scene_;
  const PictureSize size_;
  const float pixels_;
  const std::chrono::milliseconds timeout_;
  std::vector<std::unique_ptr<Model>> models_;
  glm::dvec3 min_{0}, max_{0};  ///< of all instances, in the scene
  double near_ = 0;             ///< no nearer than one lattice step of any instance, so that depths compare
  core::CameraPath path_;
  Lattice ground_lattice_;
  std::shared_ptr<const core::Cut> ground_;
  render::Renderer backdrop_{1, render::shareMemory(kBackdropBytes).gpu};
};

}  // namespace lode::app
