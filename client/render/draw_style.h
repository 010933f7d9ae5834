#pragma once

#include <glm/glm.hpp>

#include "client/render/shown_colours.h"

namespace lode::render {

struct DrawStyle {
  ColorMode show = ColorMode::kSurface;
  glm::dvec3 up{0};                                    ///< of the model, where its sky is; 0: as the view
  ShownInstance instance = {};                         ///< of the model, among others
  float exposure = 1;                                  ///< by which the light is multiplied, > 0
  glm::vec3 background_top_srgb{0.30f, 0.34f, 0.39f};  ///< 0..1
  glm::vec3 background_bottom_srgb{0.10f, 0.11f, 0.13f};
  bool over = false;  ///< what the target has stays and hides what is behind it; no background is drawn

  bool operator==(const DrawStyle&) const = default;
};

}  // namespace lode::render
