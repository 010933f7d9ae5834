#include "client/app/window/panel/start_page.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <imgui.h>

#include "client/app/window/panel/panel_window.h"
#include "client/app/window/panel/panel_words.h"

namespace lode::app {
namespace {

constexpr float kPageEm = 34, kButtonEm = 5, kTargetNameEm = 12;
constexpr ImGuiWindowFlags kPageWindow = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                         ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                         ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings;

/// Draws the path box and its button. @return the typed target when the user presses the button or Enter.
std::string drawPathBox(PathText& path, bool enter, float width_px) {
  const float button_px = kButtonEm * ImGui::GetFontSize();
  ImGui::SetNextItemWidth(width_px - button_px - ImGui::GetStyle().ItemSpacing.x);
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::InputTextWithHint("##path", "path of a PLY file, a store or a scene", path.data(), path.size());
  ImGui::SameLine();
  // ImGui misses an Enter that is pressed and released within one frame.
  const bool is_chosen = ImGui::Button("Open", {button_px, 0}) || enter;
  const char* const home = std::getenv("HOME");
  return is_chosen ? typedTarget(path.data(), home != nullptr ? home : "") : "";
}

/// Draws a target as its name and its folder. @return true if the user has clicked on it.
bool drawTarget(const OfferedTarget& one, size_t number, float width_px) {
  const std::filesystem::path path(one.target);
  const float name_px = kTargetNameEm * ImGui::GetFontSize();
  ImGui::BeginDisabled(one.is_missing);
  const std::string name = onOneLine(path.filename().string(), name_px);
  const bool is_chosen = ImGui::Selectable((name + "##" + std::to_string(number)).c_str(), false,
                                           ImGuiSelectableFlags_None, {width_px, 0});
  ImGui::SameLine(name_px + 2 * ImGui::GetStyle().ItemSpacing.x);
  const std::string place =
      one.is_missing ? "missing: " + path.parent_path().string() : path.parent_path().string();
  ImGui::TextColored(kMuted, "%s", onOneLine(place, width_px - name_px).c_str());
  ImGui::EndDisabled();
  return is_chosen;
}

}  // namespace

std::string typedTarget(std::string text, const std::string& home) {
  const auto is_space = [](unsigned char sign) { return sign == ' ' || sign == '\t' || sign == '\n'; };
  text.erase(std::find_if_not(text.rbegin(), text.rend(), is_space).base(), text.end());
  text.erase(text.begin(), std::ranges::find_if_not(text, is_space));
  if (!home.empty() && (text == "~" || text.starts_with("~/"))) return home + text.substr(1);
  return text;
}

std::string drawStartPage(const StartPage& page, PathText& path) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width_px = fittingPx(kPageEm * ImGui::GetFontSize());
  ImGui::SetNextWindowPos({display.x / 2, display.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  PanelScroll::limit();
  ImGui::SetNextWindowBgAlpha(0.9f);
  ImGui::Begin("start", nullptr, kPageWindow);
  ImGui::PushTextWrapPos(width_px + ImGui::GetStyle().WindowPadding.x);
  ImGui::TextUnformatted("Lodestream");
  ImGui::TextColored(kMuted, "Drop a PLY file, a store or a scene on this window, or open one here:");
  std::string chosen = drawPathBox(path, page.enter, width_px);
  if (!page.message.empty()) ImGui::TextColored(kBad, "%s", page.message.c_str());
  if (!page.recent.empty()) {
    ImGui::Separator();
    ImGui::TextColored(kMuted, "Opened last:");
  }
  for (size_t number = 0; number < page.recent.size(); ++number)
    if (drawTarget(page.recent[number], number, width_px)) chosen = page.recent[number].target;
  ImGui::PopTextWrapPos();
  ImGui::End();
  return chosen;
}

}  // namespace lode::app
