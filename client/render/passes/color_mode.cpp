#include "client/render/passes/color_mode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "client/render/passes/mesh_shaders.h"

namespace lode::render {
namespace {

constexpr std::array<glm::u8vec3, kTexelColourCount> kTexelLadder{
    {{220, 50, 40}, {235, 200, 60}, {110, 190, 90}, {70, 170, 200}, {49, 104, 190}, {130, 130, 130}}};
constexpr std::array<const char*, kTexelColourCount> kTexelMeanings{
    "1/4 texel per pixel or less: blurred", "1/2", "1", "2", "4 or more", "no texture"};

/// Colours that colour-blind people can also tell apart. Source: lightened colours of Okabe & Ito, Color
/// Universal Design, 2008. The last four colours are mixtures of the first eight.
constexpr std::array<glm::u8vec3, 12> kLadder{{{240, 228, 66},
                                               {230, 159, 0},
                                               {213, 94, 0},
                                               {204, 121, 167},
                                               {120, 94, 200},
                                               {0, 114, 178},
                                               {86, 180, 233},
                                               {0, 158, 115},
                                               {150, 200, 90},
                                               {170, 170, 170},
                                               {130, 90, 60},
                                               {90, 110, 120}}};

/// Colour of errors up to `part` times the threshold. The last bin is for larger errors.
struct ErrorBin {
  float part;
  glm::u8vec3 colour;
};
constexpr std::array<ErrorBin, 5> kErrorBins{{{0.125f, {49, 104, 190}},
                                              {0.25f, {70, 170, 200}},
                                              {0.5f, {110, 190, 90}},
                                              {1, {235, 200, 60}},
                                              {0, {220, 50, 40}}}};

/// Colour of parts up to an age of `seconds`. The last bin is for older parts.
struct AgeBin {
  float seconds;
  glm::u8vec3 colour;
};
constexpr std::array<AgeBin, 5> kAgeBins{{{0.25f, {220, 50, 40}},
                                          {1, {235, 200, 60}},
                                          {4, {110, 190, 90}},
                                          {kOldS, {70, 170, 200}},
                                          {0, {49, 104, 190}}}};

constexpr size_t kMostNodesInLegend = 16;

size_t ageBin(float age_s) {
  size_t bin = 0;
  while (bin + 1 < kAgeBins.size() && age_s > kAgeBins[bin].seconds) ++bin;
  return bin;
}

std::string ageMeaning(size_t bin) {
  char text[48];
  if (bin + 1 == kAgeBins.size()) return "older";
  std::snprintf(text, sizeof text, "shown for up to %.3g s", static_cast<double>(kAgeBins[bin].seconds));
  return text;
}

size_t errorBin(float error_rad, float threshold_rad) {
  size_t bin = 0;
  while (bin + 1 < kErrorBins.size() && error_rad > kErrorBins[bin].part * threshold_rad) ++bin;
  return bin;
}

glm::u8vec3 ladder(uint32_t step) { return kLadder[step % kLadder.size()]; }

/// Derives a node's colour from the node's key and the number of the instance.
glm::u8vec3 colourOfNode(NodeKey node, uint32_t instance) {
  const uint64_t hash = (node.value ^ instance * 0xbf58476d1ce4e5b9ull) * 0x9e3779b97f4a7c15ull;
  const double hue = static_cast<double>(hash >> 40) / (1 << 24);
  const double light = 0.6 + 0.4 * static_cast<double>(hash >> 20 & 0xfffff) / (1 << 20);
  const glm::dvec3 third(0, 2.0 / 3, 1.0 / 3);
  const glm::dvec3 pure = glm::clamp(glm::abs(glm::fract(hue + third) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
  return glm::u8vec3(glm::mix(glm::dvec3(1), pure, 0.55) * light * 255.0);
}

std::string instanceName(const ShownInstance& instance) {
  if (instance.model.empty()) return "";
  return std::string(instance.model) + (instance.nth > 0 ? " " + std::to_string(instance.nth) : "") + ", ";
}

/// Lists the first instance of each model before the second instance of any model.
std::vector<LegendEntry> nodeLegend(std::span<const DrawItem> drawn, float /*threshold_px*/) {
  std::map<std::tuple<uint32_t, uint32_t, NodeKey>, ShownInstance> nodes;
  for (const DrawItem& part : drawn)
    nodes.emplace(std::tuple(part.instance.nth, part.instance.number, part.node), part.instance);
  std::vector<LegendEntry> legend;
  for (const auto& [order, instance] : nodes) {
    if (legend.size() == kMostNodesInLegend) {
      legend.push_back(
          {{200, 200, 200},
           "and " + std::to_string(nodes.size() - kMostNodesInLegend) + " more nodes, each in its own colour",
           nodes.size() - kMostNodesInLegend});
      break;
    }
    const NodeKey node = std::get<NodeKey>(order);
    legend.push_back(
        {colourOfNode(node, instance.number), instanceName(instance) + "node " + nodeName(node)});
  }
  return legend;
}

glm::u8vec3 depthColour(const DrawItem& part, float /*threshold_rad*/, uint32_t /*instance*/) {
  return ladder(static_cast<uint32_t>(part.node.depth()));
}

glm::u8vec3 lodColour(const DrawItem& part, float /*threshold_rad*/, uint32_t /*instance*/) {
  return ladder(part.lod);
}

/// Describes the drawn depths or LODs, one entry each, and marks the smallest and the largest.
std::vector<LegendEntry> legendOfSteps(const std::set<uint32_t>& steps, const std::string& name,
                                       const char* first_mark, const char* last_mark) {
  std::vector<LegendEntry> legend;
  for (const uint32_t step : steps) legend.push_back({ladder(step), name + std::to_string(step)});
  if (legend.size() < 2) return legend;
  legend.front().meaning += first_mark;
  legend.back().meaning += last_mark;
  return legend;
}

std::vector<LegendEntry> depthLegend(std::span<const DrawItem> drawn, float /*threshold_px*/) {
  std::set<uint32_t> depths;
  for (const DrawItem& part : drawn) depths.insert(static_cast<uint32_t>(part.node.depth()));
  return legendOfSteps(depths, "depth ", ", the coarsest shown", ", the finest shown");
}

std::vector<LegendEntry> lodLegend(std::span<const DrawItem> drawn, float /*threshold_px*/) {
  std::set<uint32_t> lods;
  for (const DrawItem& part : drawn) lods.insert(part.lod);
  std::vector<LegendEntry> legend = legendOfSteps(lods, "LOD ", ", the finest shown", ", the coarsest shown");
  if (lods.contains(0)) legend.front().meaning = "LOD 0, the finest of its node";
  return legend;
}

std::string errorMeaning(size_t bin, float threshold_px) {
  char text[32];
  const bool is_last = bin + 1 == kErrorBins.size();
  std::snprintf(text, sizeof text, is_last ? "above %.3g px" : "up to %.3g px",
                static_cast<double>(threshold_px * (is_last ? 1 : kErrorBins[bin].part)));
  return text;
}

glm::u8vec3 errorColour(const DrawItem& part, float threshold_rad, uint32_t /*instance*/) {
  return kErrorBins[errorBin(part.error_rad, threshold_rad)].colour;
}

std::vector<LegendEntry> errorLegend(std::span<const DrawItem> /*drawn*/, float threshold_px) {
  std::vector<LegendEntry> legend;
  for (size_t bin = 0; bin < kErrorBins.size(); ++bin)
    legend.push_back({kErrorBins[bin].colour, errorMeaning(bin, threshold_px)});
  return legend;
}

glm::u8vec3 ageColour(const DrawItem& part, float /*threshold_rad*/, uint32_t /*instance*/) {
  return kAgeBins[ageBin(part.age_s)].colour;
}

std::vector<LegendEntry> ageLegend(std::span<const DrawItem> /*drawn*/, float /*threshold_px*/) {
  std::vector<LegendEntry> legend;
  for (size_t bin = 0; bin < kAgeBins.size(); ++bin)
    legend.push_back({kAgeBins[bin].colour, ageMeaning(bin)});
  return legend;
}

glm::u8vec3 nodeColour(const DrawItem& part, float /*threshold_rad*/, uint32_t instance) {
  return colourOfNode(part.node, instance);
}

std::vector<LegendEntry> normalLegend(std::span<const DrawItem> /*drawn*/, float /*threshold_px*/) {
  return {{{255, 128, 128}, "faces +x"}, {{0, 128, 128}, "faces -x"},   {{128, 255, 128}, "faces +y"},
          {{128, 0, 128}, "faces -y"},   {{128, 128, 255}, "faces +z"}, {{128, 128, 0}, "faces -z"}};
}

std::vector<LegendEntry> texelLegend(std::span<const DrawItem> /*drawn*/, float /*threshold_px*/) {
  std::vector<LegendEntry> legend;
  for (size_t i = 0; i < kTexelColourCount; ++i) legend.push_back({kTexelLadder[i], kTexelMeanings[i]});
  return legend;
}

constexpr std::array kModes{
    ColorModeTraits{.mode = ColorMode::kSurface, .name = "surface"},
    ColorModeTraits{.mode = ColorMode::kUnlit,
                    .name = "unlit",
                    .explanation = "surface colours without light",
                    .draw_flags = kDrawUnlit},
    ColorModeTraits{
        .mode = ColorMode::kWireframe,
        .name = "wireframe",
        .explanation =
            "triangle edges over the surface; where triangles are very small, the edges darken it"},
    ColorModeTraits{
        .mode = ColorMode::kNormals, .name = "normals", .draw_flags = kDrawNormals, .legend = normalLegend},
    ColorModeTraits{
        .mode = ColorMode::kTexels, .name = "texels", .draw_flags = kDrawTexels, .legend = texelLegend},
    ColorModeTraits{.mode = ColorMode::kNodes, .name = "nodes", .colour = nodeColour, .legend = nodeLegend},
    ColorModeTraits{
        .mode = ColorMode::kDepths, .name = "depths", .colour = depthColour, .legend = depthLegend},
    ColorModeTraits{.mode = ColorMode::kLods, .name = "lods", .colour = lodColour, .legend = lodLegend},
    ColorModeTraits{
        .mode = ColorMode::kErrors, .name = "errors", .colour = errorColour, .legend = errorLegend},
    ColorModeTraits{.mode = ColorMode::kAges,
                    .name = "ages",
                    .shows_time = true,
                    .colour = ageColour,
                    .legend = ageLegend},
    ColorModeTraits{.mode = ColorMode::kClay,
                    .name = "clay",
                    .explanation = "the shape in mid-grey, without the surface's colours",
                    .draw_flags = kDrawClay},
    ColorModeTraits{.mode = ColorMode::kMatcap,
                    .name = "matcap",
                    .explanation = "the shape in a studio's light, without the surface's colours",
                    .draw_flags = kDrawMatcap},
};

constexpr bool isInOrder() {
  for (size_t i = 0; i < kModes.size(); ++i)
    if (static_cast<size_t>(kModes[i].mode) != i) return false;
  return true;
}
static_assert(isInOrder());

}  // namespace

std::string nodeName(NodeKey node) {
  std::string name = "root";
  for (int depth = 1; depth <= node.depth(); ++depth)
    name += "/" + std::to_string(node.ancestorAt(depth).octant());
  return name;
}

const std::array<glm::u8vec3, kTexelColourCount>& texelColours() noexcept { return kTexelLadder; }

std::span<const ColorModeTraits> colorModes() noexcept { return kModes; }

const ColorModeTraits& traitsOf(ColorMode show) noexcept { return kModes[static_cast<size_t>(show)]; }

std::optional<ColorMode> colorModeNamed(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(kModes, name, &ColorModeTraits::name);
  if (found == kModes.end()) return std::nullopt;
  return found->mode;
}

std::string colorModeNames() {
  std::string names;
  for (const ColorModeTraits& mode : kModes) names += (names.empty() ? "" : ", ") + std::string(mode.name);
  return names;
}

glm::u8vec3 colourOf(ColorMode show, const DrawItem& part, float threshold_rad, uint32_t instance) {
  const ColorModeTraits& mode = traitsOf(show);
  return mode.colour == nullptr ? glm::u8vec3(255) : mode.colour(part, threshold_rad, instance);
}

std::vector<LegendEntry> legendOf(ColorMode show, std::span<const DrawItem> drawn, float threshold_px) {
  const ColorModeTraits& mode = traitsOf(show);
  return mode.legend == nullptr ? std::vector<LegendEntry>() : mode.legend(drawn, threshold_px);
}

}  // namespace lode::render
