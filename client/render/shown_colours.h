#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/draw_item.h"
#include "common/node_key.h"

namespace lode::render {

/// What a picture shows of a model.
enum class ColorMode : uint8_t {
  kSurface,    ///< its paint in the light
  kUnlit,      ///< its paint alone
  kWireframe,  ///< triangles, those behind hidden
  kNormals,    ///< x, y and z as red, green and blue
  kTexels,     ///< how many of its images' lie under a pixel
  kNodes,
  kDepths,  ///< of nodes in the octree
  kLods,    ///< of nodes
  kErrors,  ///< projected, when the cut was made
  kAges,    ///< how long they are in the picture
};
constexpr int kColorModeCount = 10;
constexpr float kOldS = 16;  ///< what is older has no other colour any more

std::string_view nameOf(ColorMode show) noexcept;
std::optional<ColorMode> colorModeNamed(std::string_view name) noexcept;
/// "surface, unlit, ...", for help and errors.
std::string showNames();

/// Each part is drawn in one colour.
constexpr bool coloursParts(ColorMode show) noexcept { return show >= ColorMode::kNodes; }
/// sRGB. @param threshold_rad  of the cut, for errors. @param place  its number, for nodes.
glm::u8vec3 colourOf(ColorMode show, const DrawItem& part, float threshold_rad,
                     uint32_t instance = 0) noexcept;

/// sRGB, for a quarter of a texel a pixel or less, a half, 1, 2, 4 or more, between which colours are mixed;
/// and for what has no image.
constexpr size_t kTexelColourCount = 6;
const std::array<glm::u8vec3, kTexelColourCount>& texelColours() noexcept;

/// As `lodestreamd info --nodes` names it: "root/3/0".
std::string nodeName(NodeKey node);

/// A colour and what it means.
struct LegendEntry {
  glm::u8vec3 colour{0};
  std::string meaning;
  uint64_t stands_for = 1;  ///< so many colours

  bool operator==(const LegendEntry&) const = default;
};
/// What a picture shows that no colours explain; empty where there is nothing to say.
std::string_view explanationOf(ColorMode show) noexcept;
/// Of what is drawn. @param threshold_px  of the picture. Empty where colours mean nothing.
std::vector<LegendEntry> legendOf(ColorMode show, std::span<const DrawItem> drawn, float threshold_px);

}  // namespace lode::render
