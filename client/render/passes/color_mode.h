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

#include "client/render/residency/draw_item.h"
#include "common/node_key.h"

namespace lode::render {

/// Meaning of the colours in a picture.
enum class ColorMode : uint8_t {
  kSurface,    ///< lit surface colours
  kUnlit,      ///< surface colours without light
  kWireframe,  ///< triangle edges, hidden lines removed
  kNormals,    ///< x, y and z as red, green and blue
  kTexels,     ///< texture texels per pixel
  kNodes,
  kDepths,  ///< depth of nodes in the octree
  kLods,    ///< LOD of parts
  kErrors,  ///< projected error when the cut was made
  kAges,    ///< time since parts entered the picture
};
constexpr int kColorModeCount = 10;
constexpr float kOldS = 16;  ///< age from which the colour no longer changes

std::string_view nameOf(ColorMode show) noexcept;
std::optional<ColorMode> colorModeNamed(std::string_view name) noexcept;
/// Returns "surface, unlit, ..." for help texts and errors.
std::string colorModeNames();

/// True if the mode draws each part in one colour.
constexpr bool coloursParts(ColorMode show) noexcept { return show >= ColorMode::kNodes; }
/// Returns the sRGB colour of a part. @param threshold_rad  the cut's threshold, for kErrors.
/// @param instance  ShownInstance::number, for kNodes.
glm::u8vec3 colourOf(ColorMode show, const DrawItem& part, float threshold_rad,
                     uint32_t instance = 0) noexcept;

/// sRGB colours of kTexels: for 1/4 texel a pixel or less, 1/2, 1, 2, 4 or more (interpolated between them),
/// and for surfaces without an image.
constexpr size_t kTexelColourCount = 6;
const std::array<glm::u8vec3, kTexelColourCount>& texelColours() noexcept;

/// Returns a node's name as in `lodestreamd info --nodes`: "root/3/0".
std::string nodeName(NodeKey node);

/// A colour and what it means.
struct LegendEntry {
  glm::u8vec3 colour{0};
  std::string meaning;
  uint64_t stands_for = 1;  ///< number of colours that this entry summarizes

  bool operator==(const LegendEntry&) const = default;
};
/// Describes modes that have no legend; empty for the others.
std::string_view explanationOf(ColorMode show) noexcept;
/// Returns the legend for the drawn parts; empty if colours encode nothing.
/// @param threshold_px  the picture's threshold.
std::vector<LegendEntry> legendOf(ColorMode show, std::span<const DrawItem> drawn, float threshold_px);

}  // namespace lode::render
