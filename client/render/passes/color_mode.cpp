#include "client/render/passes/color_mode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <utility>

namespace lode::render {
namespace {

constexpr std::array<std::string_view, kColorModeCount> kNames{
    "surface", "unlit", "wireframe", "normals", "texels", "nodes", "depths", "lods", "errors", "ages"};

constexpr std::array<glm::u8vec3, kTexelColourCount> kTexelLadder{
    {{220, 50, 40}, {235, 200, 60}, {110, 190, 90}, {70, 170, 200}, {49, 104, 190}, {130, 130, 130}}};
constexpr std::array<const char*, kTexelColourCount> kTexelMeanings{
    "1/4 texel per pixel or less: blurred", "1/2", "1", "2", "4 or more", "no texture"};

/// Colours that people can distinguish, even if they are colour-blind. Source: the colours of Okabe & Ito,
/// Color Universal Design, 2008, lightened. The last four are mixtures of the others.
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

/// Derives the hue and lightness of a node's colour from the key and the instance.
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

/// Returns the legend of kNodes. Lists the first instance of each model before the second instance of any
/// model.
std::vector<LegendEntry> legendOfNodes(std::span<const DrawItem> drawn) {
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

/// Describes a depth or an LOD, and marks the coarsest and the finest that are drawn.
std::string stepMeaning(ColorMode show, uint32_t step, bool is_first, bool is_last) {
  const bool is_depth = show == ColorMode::kDepths;
  std::string meaning = (is_depth ? "depth " : "LOD ") + std::to_string(step);
  if (!is_depth && step == 0) return meaning + ", the finest of its node";
  if (is_first == is_last) return meaning;
  return meaning + (is_first == is_depth ? ", the coarsest shown" : ", the finest shown");
}

std::string errorMeaning(size_t bin, float threshold_px) {
  char text[32];
  const bool is_last = bin + 1 == kErrorBins.size();
  std::snprintf(text, sizeof text, is_last ? "above %.3g px" : "up to %.3g px",
                static_cast<double>(threshold_px * (is_last ? 1 : kErrorBins[bin].part)));
  return text;
}

}  // namespace

std::string nodeName(NodeKey node) {
  std::string name = "root";
  for (int depth = 1; depth <= node.depth(); ++depth)
    name += "/" + std::to_string(node.ancestorAt(depth).octant());
  return name;
}

const std::array<glm::u8vec3, kTexelColourCount>& texelColours() noexcept { return kTexelLadder; }

std::string_view nameOf(ColorMode show) noexcept { return kNames[static_cast<size_t>(show)]; }

std::optional<ColorMode> colorModeNamed(std::string_view name) noexcept {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ColorMode>(found - kNames.begin());
}

std::string colorModeNames() {
  std::string names;
  for (const std::string_view name : kNames) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

glm::u8vec3 colourOf(ColorMode show, const DrawItem& part, float threshold_rad, uint32_t instance) noexcept {
  switch (show) {
    case ColorMode::kNodes:
      return colourOfNode(part.node, instance);
    case ColorMode::kDepths:
      return ladder(static_cast<uint32_t>(part.node.depth()));
    case ColorMode::kLods:
      return ladder(part.lod);
    case ColorMode::kErrors:
      return kErrorBins[errorBin(part.error_rad, threshold_rad)].colour;
    case ColorMode::kAges:
      return kAgeBins[ageBin(part.age_s)].colour;
    default:
      return glm::u8vec3(255);
  }
}

std::string_view explanationOf(ColorMode show) noexcept {
  if (show == ColorMode::kUnlit) return "surface colours without light";
  if (show == ColorMode::kWireframe)
    return "triangle edges; triangles too small for lines are shown as a surface";
  return "";
}

std::vector<LegendEntry> legendOf(ColorMode show, std::span<const DrawItem> drawn, float threshold_px) {
  if (show == ColorMode::kNormals)
    return {{{255, 128, 128}, "faces +x"}, {{0, 128, 128}, "faces -x"},   {{128, 255, 128}, "faces +y"},
            {{128, 0, 128}, "faces -y"},   {{128, 128, 255}, "faces +z"}, {{128, 128, 0}, "faces -z"}};
  if (show == ColorMode::kNodes) return legendOfNodes(drawn);
  std::vector<LegendEntry> legend;
  if (show == ColorMode::kTexels) {
    for (size_t i = 0; i < kTexelColourCount; ++i) legend.push_back({kTexelLadder[i], kTexelMeanings[i]});
  }
  if (show == ColorMode::kAges) {
    for (size_t bin = 0; bin < kAgeBins.size(); ++bin)
      legend.push_back({kAgeBins[bin].colour, ageMeaning(bin)});
  }
  if (show == ColorMode::kErrors) {
    for (size_t bin = 0; bin < kErrorBins.size(); ++bin)
      legend.push_back({kErrorBins[bin].colour, errorMeaning(bin, threshold_px)});
  }
  if (show == ColorMode::kDepths || show == ColorMode::kLods) {
    std::map<uint32_t, glm::u8vec3> steps;
    for (const DrawItem& part : drawn)
      steps.emplace(show == ColorMode::kDepths ? static_cast<uint32_t>(part.node.depth()) : part.lod,
                    colourOf(show, part, 0));
    for (const auto& [step, colour] : steps)
      legend.push_back(
          {colour, stepMeaning(show, step, step == steps.begin()->first, step == steps.rbegin()->first)});
  }
  return legend;
}

}  // namespace lode::render
