#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode {

/// Parses an axis such as "y" or "-z". Returns nothing for other text.
std::optional<glm::dvec3> parseAxis(std::string_view text) noexcept;
/// Returns the text that parseAxis() reads as an axis. @param axis  a result of parseAxis().
std::string nameOfAxis(const glm::dvec3& axis);

/// Guesses the up axis of a model, y or z, because files do not record the up axis. Compares areas of a
/// coarse mesh: terrain faces up, and standing objects have a flat foot and no flat top. Returns y if neither
/// rule decides. The section "Up axis" of docs/architecture.md gives the rules in full.
glm::dvec3 guessUp(const Mesh& coarse);

}  // namespace lode
