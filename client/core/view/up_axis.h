#pragma once

#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::core {

/// "y", "-z" and the like. Nothing for another text.
std::optional<glm::dvec3> parseAxis(std::string_view text) noexcept;

/// Which axis of a model is up, y or z, since files do not say. Guessed from the areas of a coarse mesh of
/// it: ground that is seen from one side faces up, and what stands has a flat foot and no flat top. y where
/// neither tells. Source of the limits: docs/architecture.md, "Which way is up".
glm::dvec3 guessUp(const Mesh& coarse);

}  // namespace lode::core
