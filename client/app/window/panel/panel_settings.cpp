#include "client/app/window/panel/panel_settings.h"

#include <algorithm>
#include <string>

#include <imgui.h>

#include "client/app/window/pacing.h"
#include "client/app/window/section_plane.h"
#include "common/byte_size.h"

namespace lode::app {
namespace {

constexpr float kSettingsEm = 21, kSliderEm = 9;
constexpr ImGuiSliderFlags kLinear = ImGuiSliderFlags_NoInput | ImGuiSliderFlags_AlwaysClamp;
constexpr ImGuiSliderFlags kLogarithmic = kLinear | ImGuiSliderFlags_Logarithmic;

void drawMemory(uint64_t& memory_bytes) {
  auto step = static_cast<int>(memoryStepAt(memory_bytes));
  if (ImGui::SliderInt("memory", &step, 0, kMemorySteps.size() - 1, describeBytes(memory_bytes).c_str(),
                       kLinear))
    memory_bytes = kMemorySteps[static_cast<size_t>(step)];
  ImGui::TextDisabled("half of it on the GPU");
}

/// Draws a slider that chooses a name from a list.
template <typename Names, typename NameOf>
void drawChoice(const char* label, const Names& names, const NameOf& name_of, size_t& number) {
  auto chosen = static_cast<int>(number);
  const std::string name(name_of(names[number]));
  if (ImGui::SliderInt(label, &chosen, 0, static_cast<int>(names.size()) - 1, name.c_str(), kLinear))
    number = static_cast<size_t>(chosen);
}

void drawChoices(Settings& settings) {
  drawChoice(
      "background", kBackgrounds, [](const Background& one) { return one.name; }, settings.background);
  drawChoice(
      "section", kCapColours, [](const CapColour& one) { return one.name; }, settings.cap_colour);
  drawChoice(
      "unit of length", kUnits, [](std::string_view unit) { return unit.empty() ? "not set" : unit; },
      settings.unit);
}

/// Draws a button for each side of the model, three in a row.
void drawSides(std::optional<core::Side>& side) {
  const float gap_px = ImGui::GetStyle().ItemSpacing.x;
  const float width_px = (ImGui::GetContentRegionAvail().x - 2 * gap_px) / 3;
  for (size_t number = 0; number < core::kSideNames.size(); ++number) {
    if (number % 3 != 0) ImGui::SameLine();
    if (ImGui::Button(std::string(core::kSideNames[number]).c_str(), {width_px, 0}))
      side = static_cast<core::Side>(number);
  }
}

}  // namespace

float settingsWidthPx(float margin_px) {
  return std::min(kSettingsEm * ImGui::GetFontSize(),
                  std::max(1.0f, ImGui::GetIO().DisplaySize.x - 2 * margin_px));
}

Covered drawSettings(float margin_px, Settings& settings) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float em = ImGui::GetFontSize();
  const float width_px = settingsWidthPx(margin_px);
  ImGui::SetNextWindowPos({display.x - margin_px, margin_px}, ImGuiCond_Always, {1, 0});
  ImGui::SetNextWindowSizeConstraints({width_px, 0}, {width_px, std::max(1.0f, display.y - 2 * margin_px)});
  ImGui::SetNextWindowBgAlpha(0.9f);
  ImGui::Begin("settings", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav);
  ImGui::PushItemWidth(kSliderEm * em);
  ImGui::PushTextWrapPos(0);
  ImGui::Checkbox("surface colours without light", &settings.unlit);
  ImGui::Checkbox("ambient occlusion", &settings.darkens_hollows);
  ImGui::Checkbox("fade in new detail", &settings.fades);
  ImGui::SliderFloat("exposure", &settings.exposure, kLeastExposure, kLargestExposure, "%.2f", kLogarithmic);
  ImGui::Checkbox("fixed threshold", &settings.fixes_threshold);
  ImGui::SliderFloat("threshold", &settings.threshold_px, kLeastThresholdPx, kLargestThresholdPx, "%.2f px",
                     kLogarithmic);
  ImGui::BeginDisabled(settings.fixes_threshold);
  ImGui::SliderFloat("frames per second", &settings.fps, kLeastFps, kLargestFps, "%.0f", kLogarithmic);
  ImGui::EndDisabled();
  drawMemory(settings.memory_bytes);
  drawChoices(settings);
  ImGui::Checkbox("parallel", &settings.parallel);
  ImGui::SameLine(kSliderEm * em);
  ImGui::Checkbox("scale bar and axes", &settings.shows_scale);
  drawSides(settings.side);
  ImGui::TextDisabled("O closes the settings");
  ImGui::PopTextWrapPos();
  ImGui::PopItemWidth();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ImGui::End();
  return {{at.x, at.y}, {at.x + size.x, at.y + size.y}};
}

}  // namespace lode::app
