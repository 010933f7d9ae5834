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
    KeyHelp{"wheel  W  S", "zoom to the point under the pointer"},
    KeyHelp{"double click", "fly to the point"},
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
    KeyHelp{"click  C", "measure; copy the measurement"},
    KeyHelp{"V  F", "next colour mode; wireframe"},
    KeyHelp{"+  -", "finer or coarser detail"},
    KeyHelp{"P  F12", "record the camera path; save a screenshot"},
    KeyHelp{"O", "settings"},
    KeyHelp{"drop a file", "open it in this window"},
    KeyHelp{"H  F11  F1", "hide the panel; full screen; show this help"},
    KeyHelp{"Esc", "quit"},
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

void drawHelp(CameraKind camera, PanelScroll& scroll) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.9f);
  PanelScroll::limit();
  ImGui::Begin("help", nullptr, kPlainWindow);
  const float keys_px = ImGui::GetFontSize() * kKeysEm;
  const float effect_px = std::max(widthOf(cameraHelp(camera)), widthOf(kCommonHelp));
  ImGui::PushTextWrapPos(0);  // wraps at the end of the column or window
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, keys_px);
    ImGui::TableSetupColumn("effect", ImGuiTableColumnFlags_WidthFixed,
                            fittingPx(keys_px + effect_px) - keys_px);
    drawKeys(cameraHelp(camera));
    drawKeys(kCommonHelp);
    ImGui::EndTable();
  }
  ImGui::TextColored(kMuted, "Press any key to close; F1 or ? opens this help");
  ImGui::PopTextWrapPos();
  scroll.follow();
  ImGui::End();
}

}  // namespace lode::app
