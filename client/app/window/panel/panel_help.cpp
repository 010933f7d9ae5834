#include "client/app/window/panel/panel_help.h"

#include <algorithm>
#include <span>

#include <imgui.h>

#include "client/app/window/panel/key_help.h"
#include "client/app/window/panel/panel_frame.h"

namespace lode::app {
namespace {

constexpr float kKeysEm = 6.5f;

float widthOf(std::span<const KeyHelp> keys) {
  float width_px = 0;
  for (const KeyHelp& key : keys) width_px = std::max(width_px, ImGui::CalcTextSize(key.what.data()).x);
  return width_px;
}

void drawKeys(std::span<const KeyHelp> keys) {
  for (const KeyHelp& key : keys) {
    nameRow(key.keys.data());
    ImGui::TextUnformatted(key.what.data());
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
  const float what_px = std::max(widthOf(cameraHelp(camera)), widthOf(commonHelp()));
  ImGui::PushTextWrapPos(0);  // where a column or the window ends
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, keys_px);
    ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthFixed, fittingPx(keys_px + what_px) - keys_px);
    drawKeys(cameraHelp(camera));
    drawKeys(commonHelp());
    ImGui::EndTable();
  }
  ImGui::TextColored(kMuted, "any key closes this, F1 or ? opens it");
  ImGui::PopTextWrapPos();
  scroll.follow();
  ImGui::End();
}

}  // namespace lode::app
