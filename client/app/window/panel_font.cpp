#include "client/app/window/panel_font.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace lode::app {
namespace {

constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";  // fonts-dejavu-core
constexpr float kOwnTextPx = 13;  ///< ImGui's letters are bitmaps: legible at whole multiples of this only

}  // namespace

void setPanelScale(float scale) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Clear();
  if (std::ifstream(kFontFile)) {
    fonts.AddFontFromFileTTF(kFontFile, std::round(kTextPx * scale));
  } else {
    ImFontConfig own;
    own.SizePixels = kOwnTextPx * std::max(1.0f, std::round(scale));
    fonts.AddFontDefault(&own);
  }
  ImGuiStyle style;
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = 5;
  style.WindowBorderSize = 0;
  style.FrameRounding = 3;
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

}  // namespace lode::app
