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

/// Property that the colours in a picture show. Each mode has a row in the table of color_mode.cpp.
enum class ColorMode : uint8_t {
  kSurface,    ///< surface colours with light
  kUnlit,      ///< surface colours without light
  kWireframe,  ///< triangle edges over the lit surface, without hidden lines
  kNormals,    ///< normals, with x, y and z as red, green and blue
  kTexels,     ///< number of texture texels per pixel
  kNodes,      ///< nodes, each in its own colour
  kDepths,     ///< depth of each part's node in the octree
  kLods,       ///< LOD of each part
  kErrors,     ///< projected error of each part in the view for which the cut was made
  kAges,       ///< time since each part entered the picture
  kClay,       ///< the lit surface in mid-grey, without its colours
  kMatcap,     ///< the surface without its colours, lit by a studio that turns with the camera
};
constexpr float kOldS = 16;  ///< age in seconds after which a part's colour no longer changes

/// A colour and its meaning.
struct LegendEntry {
  glm::u8vec3 colour{0};
  std::string meaning;
  uint64_t stands_for = 1;  ///< number of colours that this entry summarizes

  bool operator==(const LegendEntry&) const = default;
};

/// Name, shader flags, colours and legend of a mode.
struct ColorModeTraits {
  ColorMode mode = ColorMode::kSurface;
  std::string_view name;
  std::string_view explanation = "";  ///< description of a mode without a legend; empty for other modes
  unsigned draw_flags = 0;            ///< bits of DrawState::flags that the mode sets
  bool shows_time = false;  ///< true if the colours change with time while the picture stays the same
  /// Function that returns the sRGB colour of a part; null if the mode does not draw each part in one colour.
  /// @param threshold_rad  the cut's threshold as an angle. @param instance  ShownInstance::number.
  glm::u8vec3 (*colour)(const DrawItem& part, float threshold_rad, uint32_t instance) = nullptr;
  /// Function that returns the legend for the drawn parts; null if the mode has no legend.
  /// @param threshold_px  the picture's threshold.
  std::vector<LegendEntry> (*legend)(std::span<const DrawItem> drawn, float threshold_px) = nullptr;
};
/// Returns all modes, in the order of the enumerators.
std::span<const ColorModeTraits> colorModes() noexcept;
const ColorModeTraits& traitsOf(ColorMode show) noexcept;

inline std::string_view nameOf(ColorMode show) noexcept { return traitsOf(show).name; }
std::optional<ColorMode> colorModeNamed(std::string_view name) noexcept;
/// Returns "surface, unlit, ..." for help texts and errors.
std::string colorModeNames();

/// Returns the sRGB colour of a part: see ColorModeTraits::colour. Returns white if the mode has no colour
/// per part.
glm::u8vec3 colourOf(ColorMode show, const DrawItem& part, float threshold_rad, uint32_t instance = 0);
/// Returns the legend for the drawn parts; empty if the mode has no legend.
/// @param threshold_px  the picture's threshold.
std::vector<LegendEntry> legendOf(ColorMode show, std::span<const DrawItem> drawn, float threshold_px);

/// Number of sRGB colours of ColorMode::kTexels. The first five are for 1/4 or less, 1/2, 1, 2, and 4 or more
/// texels per pixel; colours between these are interpolated. The last colour is for surfaces without a
/// texture.
constexpr size_t kTexelColourCount = 6;
const std::array<glm::u8vec3, kTexelColourCount>& texelColours() noexcept;

/// Returns a node's name as `lodestreamd info --nodes` prints it: "root/3/0".
std::string nodeName(NodeKey node);

}  // namespace lode::render
