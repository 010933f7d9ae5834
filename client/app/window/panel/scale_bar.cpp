#include "client/app/window/panel/scale_bar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <imgui.h>

namespace lode::app {
namespace {

constexpr ImU32 kLight = IM_COL32(240, 240, 240, 255), kDark = IM_COL32(0, 0, 0, 200);
constexpr std::array<ImU32, 3> kAxisColours{IM_COL32(240, 90, 80, 255), IM_COL32(120, 210, 90, 255),
                                            IM_COL32(100, 160, 255, 255)};
constexpr std::array<const char*, 3> kAxisNames{"x", "y", "z"};
constexpr float kAxesEm = 2.2f;    ///< length of an axis in font sizes
constexpr float kCornerEm = 3.6f;  ///< distance of the axes' origin from the corner of the picture

void drawText(ImDrawList& list, ImVec2 at, ImU32 colour, const char* text) {
  for (const auto& [x, y] : {ImVec2{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
    list.AddText({at.x + x, at.y + y}, kDark, text);
  list.AddText(at, colour, text);
}

/// Draws the axis that points farthest away first, so that the nearer axes cover it.
void drawAxes(ImDrawList& list, const std::array<glm::dvec3, 3>& axes, ImVec2 origin, float em) {
  std::array<size_t, 3> order{0, 1, 2};
  std::ranges::sort(order, [&axes](size_t a, size_t b) { return axes[a].z > axes[b].z; });
  for (const size_t axis : order) {
    const float x = static_cast<float>(axes[axis].x) * em, y = static_cast<float>(axes[axis].y) * em;
    const ImVec2 end(origin.x + x * kAxesEm, origin.y + y * kAxesEm);
    list.AddLine(origin, end, kDark, em / 4);
    list.AddLine(origin, end, kAxisColours[axis], em / 8);
    const ImVec2 size = ImGui::CalcTextSize(kAxisNames[axis]);
    drawText(list, {end.x + x * 0.45f - size.x / 2, end.y + y * 0.45f - size.y / 2}, kAxisColours[axis],
             kAxisNames[axis]);
  }
}

/// @param right  right end of the bar.
void drawBar(ImDrawList& list, const ScaleBar& bar, ImVec2 right, float em) {
  const float left = right.x - static_cast<float>(bar.length_px) / ImGui::GetIO().DisplayFramebufferScale.x;
  const float end = em / 3;
  for (const auto& [colour, width] : {std::pair{kDark, em / 4}, {kLight, em / 10}}) {
    list.AddLine({left, right.y}, right, colour, width);
    for (const float x : {left, right.x}) list.AddLine({x, right.y - end}, {x, right.y + end}, colour, width);
  }
  const ImVec2 size = ImGui::CalcTextSize(bar.text.c_str());
  drawText(list, {(left + right.x - size.x) / 2, right.y - end - size.y}, kLight, bar.text.c_str());
}

}  // namespace

std::optional<ScaleBar> scaleBarOf(const core::View& view, double distance_model, double most_px,
                                   std::string_view unit) {
  const double px_per_model = core::focalPx(view) / distance_model;
  const double most_model = most_px / px_per_model;
  if (!(most_model > 0) || !std::isfinite(most_model)) return std::nullopt;
  const double power = std::pow(10, std::floor(std::log10(most_model)));
  double length_model = power;
  for (const double factor : {2.0, 5.0})
    if (factor * power <= most_model) length_model = factor * power;
  char text[64];
  std::snprintf(text, sizeof text, "%.10g", length_model);
  return ScaleBar{length_model * px_per_model,
                  unit.empty() ? std::string(text) : text + (" " + std::string(unit))};
}

std::array<glm::dvec3, 3> axesInPicture(const core::View& view) noexcept {
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  std::array<glm::dvec3, 3> axes;
  for (int axis = 0; axis < 3; ++axis) axes[axis] = {right[axis], -view.up[axis], view.forward[axis]};
  return axes;
}

void drawScale(const ScaleMarks& marks) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  const float em = ImGui::GetFontSize();
  drawAxes(list, marks.axes, {window.x - kCornerEm * em, window.y - kCornerEm * em}, em);
  if (marks.bar) drawBar(list, *marks.bar, {window.x - 2 * kCornerEm * em, window.y - 1.5f * em}, em);
}

}  // namespace lode::app
