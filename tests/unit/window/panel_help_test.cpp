#include "client/app/window/panel/panel_help.h"

#include <string>

#include <gtest/gtest.h>
#include <imgui.h>

#include "client/app/window/panel/panel_window.h"
#include "client/app/window/panel/panel_words.h"

namespace lode::app {
namespace {

/// Lays out ImGui windows without OpenGL.
class Layout : public testing::Test {
 protected:
  Layout() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {700, 420};
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  }
  ~Layout() override { ImGui::DestroyContext(); }

  /// Lays out the help once. @return its size, which depends on the previous layout.
  static ImVec2 helpLaidOut() {
    ImGui::NewFrame();
    PanelScroll::limit();
    ImGui::Begin("help", nullptr, kPlainWindow);
    const float width_px = helpWidthPx(CameraKind::kOrbit);
    ImGui::PushTextWrapPos(width_px + ImGui::GetStyle().WindowPadding.x);
    drawHelp(CameraKind::kOrbit, width_px);
    ImGui::PopTextWrapPos();
    const ImVec2 size = ImGui::GetWindowSize();
    ImGui::End();
    ImGui::EndFrame();
    return size;
  }
};

TEST_F(Layout, givesTheHelpItsSizeAfterOneHiddenLayout) {
  helpLaidOut();
  const ImVec2 first = helpLaidOut();
  for (int i = 0; i < 3; ++i) helpLaidOut();
  const ImVec2 last = helpLaidOut();
  EXPECT_EQ(first.x, last.x);
  EXPECT_EQ(first.y, last.y);
  EXPECT_LT(last.y, 420 - 2 * kPanelMarginPx);
}

TEST_F(Layout, keepsTheHelpOffTheMiddleOfAModelBesideThePanel) {
  helpLaidOut();
  const ImVec2 size = helpLaidOut();
  const float panel_end_px = 700 * 0.4f + 2 * kPanelMarginPx;
  EXPECT_LT(kPanelMarginPx + size.x, (panel_end_px + 700) / 2);
}

TEST_F(Layout, cutsATextToOneLine) {
  ImGui::NewFrame();
  EXPECT_EQ(onOneLine("a\nb", 1000), "a b");
  const std::string cut =
      onOneLine("a long warning of several words \u00e4\u00e4\u00e4\u00e4\u00e4\u00e4", 150);
  EXPECT_TRUE(cut.ends_with("...")) << cut;
  EXPECT_LE(ImGui::CalcTextSize(cut.c_str()).x, 150);
  EXPECT_GT(ImGui::CalcTextSize(cut.c_str()).x, 100);
  ImGui::EndFrame();
}

}  // namespace
}  // namespace lode::app
