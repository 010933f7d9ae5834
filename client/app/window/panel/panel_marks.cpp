#include "client/app/window/panel/panel_marks.h"

namespace lode::app {

void drawMarks(const PickMarks& marks, const ImVec4& colour) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImU32 light = ImGui::GetColorU32(colour), dark = IM_COL32(0, 0, 0, 200);
  const float em = ImGui::GetFontSize();
  const ImVec2 unit_px = ImGui::GetIO().DisplayFramebufferScale;
  const auto placeOf = [&](const glm::dvec2& px) {
    return ImVec2(static_cast<float>(px.x) / unit_px.x, static_cast<float>(px.y) / unit_px.y);
  };
  if (marks.line) {
    const ImVec2 from = placeOf(marks.line->from_px), to = placeOf(marks.line->to_px);
    list->AddLine(from, to, dark, em / 4);
    list->AddLine(from, to, light, em / 10);
    const ImVec2 text = ImGui::CalcTextSize(marks.distance.c_str());
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    const glm::dvec2 corner =
        besideLine({{from.x, from.y}, {to.x, to.y}}, {text.x, text.y}, {window.x, window.y}, em / 2);
    const ImVec2 at(static_cast<float>(corner.x), static_cast<float>(corner.y));
    list->AddRectFilled({at.x - em / 4, at.y}, {at.x + text.x + em / 4, at.y + text.y}, dark, em / 4);
    list->AddText(at, light, marks.distance.c_str());
  }
  for (const glm::dvec2& point_px : marks.points_px) {
    list->AddCircleFilled(placeOf(point_px), em / 3, dark);
    list->AddCircleFilled(placeOf(point_px), em / 5, light);
  }
}

}  // namespace lode::app
