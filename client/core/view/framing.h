#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/camera_path.h"
#include "common/codec/model_summary.h"
#include "common/mesh.h"

namespace lode::core {

/// "y", "-z" and the like. Nothing for another text.
std::optional<glm::dvec3> parseAxis(std::string_view text) noexcept;

/// Which axis of a model is up, y or z, since files do not say. Guessed from the areas of a coarse mesh of
/// it: ground that is seen from one side faces up, and what stands has a flat foot and no flat top. y where
/// neither tells. Source of the limits: docs/architecture.md, "Which way is up".
glm::dvec3 guessUp(const Mesh& coarse);

/// How a model is looked at first.
struct Framing {
  /// What is to fill the picture: the coarsest mesh of the whole model. Null: its box.
  std::shared_ptr<const Mesh> coarse = nullptr;
  /// A coordinate axis. Nothing: guessUp(*coarse), y without a mesh.
  std::optional<glm::dvec3> up = std::nullopt;
  double aspect = 1;   ///< the picture's width by its height
  double covered = 0;  ///< of its width, from its left: the model is framed beside that
};

/// Which way is up in the picture, and for its light.
glm::dvec3 upOf(const Framing& framing);

/// The camera that every command has where none is named: at three quarters from above, as near as the whole
/// model fits into the picture. One key. It looks at the broader side, along what is +z of a model with y up
/// and -y of one with z up, turned to the right; down more steeply on what is flat.
CameraPath framingCamera(const ModelSummary& model, const Framing& framing = {});

}  // namespace lode::core
