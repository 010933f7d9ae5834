#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/camera_path.h"
#include "common/codec/model_summary.h"
#include "common/mesh.h"

namespace lode::core {

/// Parses an axis such as "y" or "-z"; nothing for other text.
std::optional<glm::dvec3> parseAxis(std::string_view text) noexcept;

/// Guesses the up axis of a model, y or z, since files do not record it. Compares areas of a coarse mesh:
/// terrain faces up, and standing objects have a flat foot and no flat top. Returns y if neither applies.
/// Source of the limits: docs/architecture.md.
glm::dvec3 guessUp(const Mesh& coarse);

/// Input for the default camera.
struct Framing {
  /// The coarsest mesh of the whole model, which shall fill the picture. Null: the model's box.
  std::shared_ptr<const Mesh> coarse = nullptr;
  /// Up axis. Nothing: guessUp(*coarse), or y without a mesh.
  std::optional<glm::dvec3> up = std::nullopt;
  double aspect = 1;   ///< width / height of the picture
  double covered = 0;  ///< covered part of the width, at the left: the model is framed in the rest
};

/// Returns the up direction for the camera and the light.
glm::dvec3 upOf(const Framing& framing);

/// Returns the default camera of every command, a path of one key: a three-quarter view from above, as near
/// as the whole model fits the picture. It shows the broader side, seen from +z of a model with y up and from
/// -y of one with z up, turned to the right. It looks down more steeply on flat models.
CameraPath framingCamera(const ModelSummary& model, const Framing& framing = {});

}  // namespace lode::core
