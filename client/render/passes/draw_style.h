#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/render/culling/occlusion_culling.h"
#include "client/render/passes/color_mode.h"
#include "client/render/passes/section.h"

namespace lode::render {

/// Appearance of a model in a picture.
struct DrawStyle {
  ColorMode show = ColorMode::kSurface;
  glm::dvec3 up{0};             ///< the model's up axis, towards the sky; 0 selects the view's up axis
  ShownInstance instance = {};  ///< instance to draw; its number selects the node colours
  float exposure = 1;           ///< brightness factor of the light; > 0
  glm::dvec2 sun_turn_rad{0};   ///< angles by which the sun is turned to the right and down: see lightFor()
  glm::vec3 background_top_srgb{0.30f, 0.34f, 0.39f};  ///< sRGB colour, 0..1
  glm::vec3 background_bottom_srgb{0.10f, 0.11f, 0.13f};
  bool hides_sky = false;  ///< if true, the background colours replace the sky of a scene
  std::optional<Section> section = std::nullopt;  ///< plane that cuts the model open, in its model frame
  bool over = false;  ///< if true, draws over the target's colours and depth, without a background

  bool operator==(const DrawStyle&) const = default;
};

/// Time and method of drawing a frame.
struct DrawTime {
  double now_s = 0;    ///< time of a monotonic clock
  bool fades = false;  ///< if true, cross-fades to parts that differ from the parts of the last frame
  OcclusionCulling occlusion_culling = OcclusionCulling::kOff;
};

}  // namespace lode::render
