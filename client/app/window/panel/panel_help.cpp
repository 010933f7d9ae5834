#include "client/app/window/panel/panel_help.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include <imgui.h>

#include "client/app/window/panel/panel_window.h"

namespace lode::app {
namespace {

/// A row of the help: keys or mouse input and their effect.
struct KeyHelp {
  std::string_view keys, effect;
};

constexpr std::array kOrbitHelp{
    KeyHelp{"drag", "orbit around the point under the pointer"},
    KeyHelp{"right drag", "pan"},
    KeyHelp{"wheel  W  S", "zoom to this point; double click: fly to it"},
};

constexpr std::array kFlyHelp{
    KeyHelp{"drag, right drag", "look around"},
    KeyHelp{"W A S D", "move"},
    KeyHelp{"Q  E", "move down or up"},
    KeyHelp{"Shift", "four times as fast"},
    KeyHelp{"wheel", "faster or slower"},
    KeyHelp{"double click", "flies to a point in orbit mode only"},
};

constexpr std::array kWalkHelp{
    KeyHelp{"drag, right drag", "look around"},
    KeyHelp{"W A S D", "walk"},
    KeyHelp{"Q  E", "lower or raise the eye"},
    KeyHelp{"Shift", "four times as fast"},
    KeyHelp{"wheel", "faster or slower"},
    KeyHelp{"double click", "flies to a point in orbit mode only"},
};

constexpr std::array kCommonHelp{
    KeyHelp{"Tab", "orbit, fly, or walk from the point under the pointer"},
    KeyHelp{"R  U", "reset the view; next up axis"},
    KeyHelp{"1 to 9", "go to a bookmark; with Ctrl: set it"},
    KeyHelp{"Alt+1 to 6  N", "front, back, left, right, top, bottom; parallel"},
    KeyHelp{"click  C", "measure; copy the measurement"},
    KeyHelp{"K  Shift+K  J", "keep; other measurements; save them as CSV"},
    KeyHelp{"Backspace", "remove the measurement kept last"},
    KeyHelp{"V  F  G", "next colour mode; wireframe; clay"},
    KeyHelp{"L, X and drag", "turn the light; move the section"},
    KeyHelp{"X  Shift+X", "next section; show the other half"},
    KeyHelp{"Z  Shift+Z", "hide a scene's model; show it alone"},
    KeyHelp{"+  -", "finer or coarser detail"},
    KeyHelp{"P  F12", "record the camera path; save a screenshot"},
    KeyHelp{"O  M", "settings; all warnings"},
    KeyHelp{"H  F11  Esc", "hide the panel; full screen; quit"},
};

std::span<const KeyHelp> cameraHelp(CameraKind camera) noexcept {
  switch (camera) {
    case CameraKind::kFly:
      return kFlyHelp;
    case CameraKind::kWalk:
      return kWalkHelp;
    case CameraKind::kOrbit:
      break;
  }
  return kOrbitHelp;
}

constexpr float kKeysEm = 6.5f;

float keysPx() { return ImGui::GetFontSize() * kKeysEm; }

float widthOf(std::span<const KeyHelp> keys) {
  float width_px = 0;
  for (const KeyHelp& key : keys) width_px = std::max(width_px, ImGui::CalcTextSize(key.effect.data()).x);
  return width_px;
}

void drawKeys(std::span<const KeyHelp> keys) {
  for (const KeyHelp& key : keys) {
    nameRow(key.keys.data());
    ImGui::TextUnformatted(key.effect.data());
  }
}

}  // namespace

float helpWidthPx(CameraKind camera) {
  const float effect_px = std::max(widthOf(cameraHelp(camera)), widthOf(kCommonHelp));
  return fittingPx(keysPx() + ImGui::GetStyle().CellPadding.x * 2 + effect_px);
}

/// The table and its columns have fixed widths. Otherwise they would follow the window, which is narrow when
/// it appears, so that its first layout would be as tall as the display.
void drawHelp(CameraKind camera, float width_px) {
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit, {width_px, 0})) {
    ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, keysPx());
    ImGui::TableSetupColumn("effect", ImGuiTableColumnFlags_WidthFixed,
                            width_px - keysPx() - ImGui::GetStyle().CellPadding.x * 2);
    ImGui::PushTextWrapPos(0);  // wraps at the end of the column
    drawKeys(cameraHelp(camera));
    drawKeys(kCommonHelp);
    ImGui::PopTextWrapPos();
    ImGui::EndTable();
  }
  ImGui::TextColored(kMuted, "A dropped file opens. Any key closes, F1 or ? opens this help");
}

}  // namespace lode::app
