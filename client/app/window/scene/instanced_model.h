#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/scene_file.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/scene/patient_opener.h"
#include "client/core/lod/cut_probe.h"
#include "client/core/view/view.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// A model of a scene in the window, and the places where it stands: none before it is open.
struct InstancedModel {
  /// Begins to open the target. @param number  among the scene's models.
  InstancedModel(size_t model_number, const std::string& target, stream::StreamOptions options,
                 std::chrono::milliseconds timeout, const render::MemoryShares& memory);

  /// Looks how far it has come. @return it has just opened.
  bool look();
  bool isOpen() const noexcept { return opened.streamer != nullptr; }
  /// It neither is open nor has failed yet.
  bool isAwaited() const noexcept { return !isOpen() && !opened.error; }

  /// As the model at a place sees a camera of the scene.
  core::View viewAt(size_t instance, const core::View& scene_view) const;
  glm::dvec3 toScene(size_t instance, const glm::dvec3& point_model) const;
  core::ModelBox box() const { return core::toModelBox(opened.model->box, opened.model->lattice.step); }
  /// Of what is drawn at a place; null while that is nothing.
  const core::CutProbe* probe(size_t instance);
  /// Those of cuts that are drawn no more, which keep all of their meshes, go.
  void dropOldProbes();
  /// How it is drawn at a place.
  render::DrawStyle styleAt(size_t instance, render::DrawStyle style, const glm::dvec3& scene_up) const;

  const size_t number;
  render::Renderer renderer;
  PatientOpener opener;
  ModelOpener::Progress opened;  ///< the last
  std::vector<Placement> instances;
  std::vector<core::View> views;  ///< by place
  stream::StreamStatus status;
  std::vector<std::optional<core::CutProbe>> probes;  ///< by place, of cuts last clicked or walked on
};

}  // namespace lode::app
