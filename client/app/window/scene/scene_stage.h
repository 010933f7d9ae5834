#pragma once

#include <memory>
#include <span>

#include "client/app/cli/scene_file.h"
#include "client/core/view/view.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/renderer.h"
#include "common/codec/model_summary.h"
#include "common/lattice.h"

namespace lode::app {

/// Returns the unique number of an instance in the scene.
/// @param model     index in Scene::models.
/// @param instance  index among the instances of that model.
constexpr uint32_t instanceNumber(size_t model, size_t instance) noexcept {
  return static_cast<uint32_t>((model + 1) << 16 ^ instance);
}

/// Returns a lattice for a scene in which models are still missing. On every side, the lattice extends beyond
/// the box of the open models by 64 times the box's longest side. This room is for the missing models. Their
/// placements alone do not tell where they will lie, because the coordinates of a georeferenced model can be
/// in the millions. Pure.
/// @param whole  summary of all open models as if they were one: see SceneStage::whole().
Lattice latticeWithRoom(const ModelSummary& whole);

/// Returns the box of `whole` in coordinates of `lattice`, clipped to the range of `lattice`. Pure.
LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole);

/// Everything in a scene except its models: the extent and the ground. Create, use and destroy it on the
/// thread of its OpenGL context.
class SceneStage {
 public:
  /// @param models  summaries of the models, indexed as in Scene::models; null for a missing model.
  SceneStage(const Scene& scene, std::span<const ModelSummary* const> models);
  ~SceneStage();

  /// Returns a summary of the scene as if it were one model, with the extent of the scene and the triangles
  /// of all instances. For a single model, returns the model's summary.
  const ModelSummary& whole() const noexcept { return whole_; }
  /// Returns the near distance for views of the scene: the largest lattice step of the instances and the
  /// ground. All models use the same near distance, so that their depths are comparable.
  double nearest() const noexcept { return near_; }

  /// Starts a picture: clears the depth buffer, and draws the ground with contact shadows if the scene has a
  /// ground.
  /// @param view  view in scene coordinates.
  void begin(const core::View& view, const render::Framebuffer& target, const render::DrawStyle& style);

 private:
  struct Ground;
  void makeGround(const Scene& scene, const glm::dvec3& min, const glm::dvec3& max);

  ModelSummary whole_;
  double near_ = 0;
  std::unique_ptr<Ground> ground_;
};

/// Draws the background into all pixels that show neither ground nor model. The background is the scene's
/// sky. If the scene has no sky, or if style.hides_sky is set, it has the background colours of the style.
/// @param renderer  renderer that draws the background; the renderer of any model in the scene will do.
void drawSky(const render::Renderer& renderer, const Scene& scene, const render::Framebuffer& target,
             render::DrawStyle style);

}  // namespace lode::app
