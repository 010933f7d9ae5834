#pragma once

#include <cstddef>
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

/// A model of the scene in the window, with its instances: none before it is open. Views and points "of the
/// scene" are in the frame of ViewedScene::summary(), as the placements are here. On the thread of its OpenGL
/// context.
struct InstancedModel {
  /// Begins to open the target. @param number  index in Scene::models.
  InstancedModel(size_t model_number, const std::string& target, stream::StreamOptions options,
                 core::Framing framing, std::chrono::milliseconds timeout,
                 const render::MemoryShares& memory);

  /// Updates `opened`, without waiting. @return true once: when the model has opened.
  bool poll();
  bool isOpen() const noexcept { return opened.streamer != nullptr; }
  /// Returns true while the first attempt to open it is under way.
  bool isAwaited() const noexcept { return !isOpen() && !opened.error; }

  /// Transforms a camera of the scene into the model's frame at an instance.
  core::View viewAt(size_t instance, const core::View& scene_view) const;
  /// Transforms a point of the model's frame into the scene, and back.
  glm::dvec3 toScene(size_t instance, const glm::dvec3& point_model) const;
  glm::dvec3 toModel(size_t instance, const glm::dvec3& point_scene) const;
  /// In the model's frame.
  core::ModelBox box() const { return core::toModelBox(opened.model->box, opened.model->lattice.step); }
  /// Returns a ray caster for the cut drawn at an instance; null if none is drawn.
  const core::CutProbe* probe(size_t instance);
  /// Frees ray casters of cuts that are no longer drawn: they keep all meshes of their cuts.
  void dropOldProbes();

  const size_t number;
  render::Renderer renderer;
  RetryingOpener opener;
  ModelOpener::Progress opened;  ///< last polled
  std::vector<Placement> instances;
  std::vector<core::View> views;  ///< by instance
  stream::StreamStatus status;
  std::vector<std::optional<core::CutProbe>> probes;  ///< by instance, made when first used
};

}  // namespace lode::app
