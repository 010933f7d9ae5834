#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/scene_file.h"
#include "client/app/window/memory_shares.h"
#include "client/core/view/view.h"
#include "client/render/framebuffer.h"
#include "client/render/passes/contact_shadows.h"
#include "client/render/renderer.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// Tells a place of a scene from all others: by the model and by which of its places it is.
constexpr uint32_t instanceNumber(size_t model, size_t instance) noexcept {
  return static_cast<uint32_t>((model + 1) << 16 ^ instance);
}

/// What a scene is beside its models: how far it reaches, its ground and its sky. On the thread of its
/// context.
class SceneStage {
 public:
  /// @param models  those of the scene, by number; null for one that is missing.
  SceneStage(const Scene& scene, std::span<const ModelSummary* const> models);

  /// A model of the scene's place and size, with the triangles of all instances.
  const ModelSummary& whole() const noexcept { return whole_; }
  /// For views: no nearer than one lattice step of any instance, so that depths compare.
  double nearest() const noexcept { return near_; }

  /// Behind all: the ground if there is one, darker where models stand. @param view  in the scene.
  void draw(const core::View& view, const render::Framebuffer& target, const render::DrawStyle& style);
  /// Where neither ground nor models are: when these are drawn.
  void drawSky(const render::Framebuffer& target, const render::DrawStyle& style) const;
  /// How the models are drawn over it; their up is still to be set.
  render::DrawStyle styleOver(const render::DrawStyle& style) const;

 private:
  static constexpr uint64_t kBackdropBytes = 1u << 20;  ///< of two triangles
  void addShadow(const ModelSummary& model, const Placement& placement, double ground_height);
  void makeGround(const Scene& scene, const glm::dvec3& min, const glm::dvec3& max);
  render::DrawStyle styleOf(render::DrawStyle style) const;

  const glm::dvec3 up_;
  const std::optional<SceneSky> sky_;
  ModelSummary whole_;
  double near_ = 0;
  Lattice ground_lattice_;
  std::vector<render::ContactShadow> shadows_;
  render::ContactShadows shadow_pass_;
  render::Renderer backdrop_{1, render::shareMemory(kBackdropBytes).gpu};
};

}  // namespace lode::app
