#include "client/app/window/panel/pick_marks.h"

#include <imgui.h>

namespace lode::app {

PickMarks marksOf(const Measure& measure, const glm::dvec3& up, std::string_view unit,
                  const core::View& view) {
  PickMarks marks;
  const std::vector<PickedPoint>& points = measure.points;
  for (const PickedPoint& point : points)
    if (const auto place_px = pointInPicture(view, point.position_model))
      marks.points_px.push_back(*place_px);
  const bool is_closed = measure.kind == MeasureKind::kArea && points.size() > 2;
  for (size_t i = is_closed ? 0 : 1; i < points.size(); ++i) {
    const PickedPoint& before = points[(i + points.size() - 1) % points.size()];
    if (const auto line = lineInPicture(view, before.position_model, points[i].position_model))
      marks.lines.push_back(*line);
  }
  marks.value = valueText(measure, up, unit);
  return marks;
}

glm::dvec2 besideLine(const PictureLine& line, const glm::dvec2& text, const glm::dvec2& window,
                      double gap) noexcept {
  const glm::dvec2 along = line.to_px - line.from_px;
  const double length = glm::length(along);
  glm::dvec2 aside = length > 0 ? glm::dvec2(-along.y, along.x) / length : glm::dvec2(0, 1);
  if (aside.y < 0) aside = -aside;
  const glm::dvec2 middle = (line.from_px + line.to_px) / 2.0;
  const glm::dvec2 corner = middle + aside * (glm::dot(glm::abs(aside), text) / 2 + gap) - text / 2.0;
  return glm::clamp(corner, glm::dvec2(gap), glm::max(glm::dvec2(gap), window - text - gap));
}

void drawMarks(const PickMarks& marks, const ImVec4& colour) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImU32 light = ImGui::GetColorU32(colour), dark = IM_COL32(0, 0, 0, 200);
  const float em = ImGui::GetFontSize();
  const ImVec2 unit_px = ImGui::GetIO().DisplayFramebufferScale;
  const auto placeOf = [&](const glm::dvec2& px) {
    return ImVec2(static_cast<float>(px.x) / unit_px.x, static_cast<float>(px.y) / unit_px.y);
  };
  for (const PictureLine& line : marks.lines)
    list->AddLine(placeOf(line.from_px), placeOf(line.to_px), dark, em / 4);
  for (const PictureLine& line : marks.lines)
    list->AddLine(placeOf(line.from_px), placeOf(line.to_px), light, em / 10);
  if (!marks.lines.empty() && !marks.value.empty()) {
    const ImVec2 from = placeOf(marks.lines.back().from_px), to = placeOf(marks.lines.back().to_px);
    const ImVec2 text = ImGui::CalcTextSize(marks.value.c_str());
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    const glm::dvec2 corner =
        besideLine({{from.x, from.y}, {to.x, to.y}}, {text.x, text.y}, {window.x, window.y}, em / 2);
    const ImVec2 at(static_cast<float>(corner.x), static_cast<float>(corner.y));
    list->AddRectFilled({at.x - em / 4, at.y}, {at.x + text.x + em / 4, at.y + text.y}, dark, em / 4);
    list->AddText(at, light, marks.value.c_str());
  }
  for (const glm::dvec2& point_px : marks.points_px) {
    list->AddCircleFilled(placeOf(point_px), em / 3, dark);
    list->AddCircleFilled(placeOf(point_px), em / 5, light);
  }
}

}  // namespace lode::app
