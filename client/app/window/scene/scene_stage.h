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

/// Returns a number that no other instance of the scene has.
/// @param model     index in Scene::models.
/// @param instance  index among the instances of that model.
constexpr uint32_t instanceNumber(size_t model, size_t instance) noexcept {
  return static_cast<uint32_t>((model + 1) << 16 ^ instance);
}

/// Returns a lattice for a scene that still misses models: around the box of the models that are open, with
/// room on each side of 64 times its longest side. Placements of missing models do not tell how far these
/// reach: a georeferenced model may lie millions of units from its placement. Pure.
/// @param whole  the box of the open models.
Lattice latticeWithRoom(const ModelSummary& whole);

/// Returns the box of `whole` in another lattice, clipped to it. Pure.
LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole);

/// The scene apart from its models: its extent, ground and sky. Made, used and destroyed on the thread of its
/// OpenGL context.
class SceneStage {
 public:
  /// @param models  summaries by index in Scene::models; null: the model is missing.
  SceneStage(const Scene& scene, std::span<const ModelSummary* const> models);
  ~SceneStage();

  /// Describes the scene as one model: its extent, and the triangles of all instances. A single model's own
  /// summary.
  const ModelSummary& whole() const noexcept { return whole_; }
  /// Near distance of views of the scene: one lattice step of the coarsest instance, so that depths of
  /// different models compare.
  double nearest() const noexcept { return near_; }

  /// Starts the picture: clears depths and draws the ground, if there is one, with contact shadows.
  /// @param view  in the scene.
  void begin(const core::View& view, const render::Framebuffer& target, const render::DrawStyle& style);

 private:
  struct Ground;
  void makeGround(const Scene& scene, const glm::dvec3& min, const glm::dvec3& max);

  ModelSummary whole_;
  double near_ = 0;
  std::unique_ptr<Ground> ground_;
};

/// Draws the background of a scene where no ground and no model was drawn: its sky, or the style's colours.
/// @param renderer  any model's.
void drawSky(const render::Renderer& renderer, const Scene& scene, const render::Framebuffer& target,
             render::DrawStyle style);

}  // namespace lode::app
