#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/scene_file.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/scene/model_opener.h"
#include "client/core/lod/cut_probe.h"
#include "client/core/view/view.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// A model of the scene in the window, with its instances. A model has no instances until it is open, and
/// while it is hidden. Views, points and placements of the scene are in the frame of ViewedScene::summary().
/// Use it only on the thread of its OpenGL context.
struct InstancedModel {
  /// @param model_number  index in Scene::models. @param target  opener of the model's target.
  InstancedModel(size_t model_number, std::unique_ptr<RetryingOpener> target, const MemoryShares& memory);

  /// Updates `opened` without waiting. @return true when the model has opened, and when its store has
  /// replaced its preview.
  bool poll();
  bool isOpen() const noexcept { return opened.streamer != nullptr; }
  /// Returns true while the first attempt to open the model is under way.
  bool isAwaited() const noexcept { return !isOpen() && !opened.error; }

  /// Transforms a view of the scene into the model's frame, for one of the model's instances.
  core::View viewAt(size_t instance, const core::View& scene_view) const;
  /// Transforms a point of the model's frame into the scene. toModel() is the inverse.
  glm::dvec3 toScene(size_t instance, const glm::dvec3& point_model) const;
  glm::dvec3 toModel(size_t instance, const glm::dvec3& point_scene) const;
  /// Returns the model's box in the model's frame.
  core::ModelBox box() const { return core::toModelBox(opened.model->box, opened.model->lattice.step); }
  /// Returns a ray caster for the cut drawn at an instance; null if no cut is drawn.
  const core::CutProbe* probe(size_t instance);
  /// Frees the ray casters of cuts that are no longer drawn, because a ray caster keeps all meshes of its cut
  /// alive.
  void dropOldProbes();

  const size_t number;
  bool is_hidden = false;  ///< true if the user has hidden the model
  render::Renderer renderer;
  std::unique_ptr<RetryingOpener> opener;  ///< never null
  ModelOpener::Progress opened;            ///< progress at the last poll
  std::vector<Placement> instances;
  std::vector<core::View> views;  ///< view of each instance
  stream::StreamStatus status;
  std::vector<std::optional<core::CutProbe>> probes;  ///< ray caster of each instance, made at first use
};

}  // namespace lode::app
