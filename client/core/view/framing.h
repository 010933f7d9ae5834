#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/camera_path.h"
#include "common/codec/model_summary.h"
#include "common/mesh.h"

namespace lode::core {

/// Side of a model, as its viewer sees it. The front is at +z if y is up, and at -y if z is up.
enum class Side : uint8_t { kFront, kBack, kLeft, kRight, kTop, kBottom };
constexpr std::array<std::string_view, 6> kSideNames{"front", "back", "left", "right", "top", "bottom"};

/// Input for the default camera.
struct Framing {
  /// The coarsest mesh of the whole model, which fills the picture. If null, the model's bounding box fills
  /// it.
  std::shared_ptr<const Mesh> coarse = nullptr;
  /// Up axis. If unset, the axis is guessUp(*coarse), or y without a mesh.
  std::optional<glm::dvec3> up = std::nullopt;
  double aspect = 1;  ///< width / height of the picture
  /// Fraction of the picture's width that a panel covers on the left; the model fills the rest.
  double covered = 0;
  /// Side to look at squarely. If unset, the camera looks at the model in a three-quarter view.
  std::optional<Side> side = std::nullopt;
  double fov_y_deg = 45;
};

/// Returns the up direction for the camera and the light.
glm::dvec3 upOf(const Framing& framing);

/// Returns the default camera of every command, as a path with one key. The camera shows the model in a
/// three-quarter view from above, as near as possible with the whole model in the picture. The model's front
/// is at +z if y is up, and at -y if z is up. The camera stands between the front and the right side, and
/// faces the broader of the two more squarely. It looks down more steeply on flat models.
CameraPath framingCamera(const ModelSummary& model, const Framing& framing = {});

}  // namespace lode::core
