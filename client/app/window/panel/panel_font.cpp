#include "client/app/window/panel/panel_font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <vector>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace lode::app {
namespace {

constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";  // fonts-dejavu-core
/// Of Debian's fonts-noto-cjk, fonts-droid-fallback, fonts-wqy-microhei, fonts-wqy-zenhei,
/// fonts-ipafont-gothic.
constexpr std::array<const char*, 5> kOtherFonts{"/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                                                 "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
                                                 "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
                                                 "/usr/share/fonts/truetype/wqy/wqy-zenhei.ttc",
                                                 "/usr/share/fonts/opentype/ipafont-gothic/ipag.ttf"};
constexpr size_t kPlainRanges = 3;  ///< values of ranges that are of Latin alone
constexpr float kOwnTextPx = 13;    ///< ImGui's letters are bitmaps: legible at whole multiples of this only

}  // namespace

void setPanelFont(float scale, const PanelLetters& letters) {
  const std::vector<ImWchar> ranges = letters.ranges<ImWchar>(IM_UNICODE_CODEPOINT_MAX);
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Clear();
  const float size_px = std::round(kTextPx * scale);
  if (std::ifstream(kFontFile)) {
    fonts.AddFontFromFileTTF(kFontFile, size_px, nullptr, ranges.data());
  } else {
    ImFontConfig own;
    own.SizePixels = kOwnTextPx * std::max(1.0f, std::round(scale));
    fonts.AddFontDefault(&own);
  }
  const auto* const other =
      std::ranges::find_if(kOtherFonts, [](const char* file) { return bool(std::ifstream(file)); });
  if (other != kOtherFonts.end() && ranges.size() > kPlainRanges) {
    ImFontConfig merged;
    merged.MergeMode = true;  // letters that are there stay
    fonts.AddFontFromFileTTF(*other, size_px, &merged, ranges.data() + 2);
  }
  ImGuiStyle style;
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = 5;
  style.WindowBorderSize = 0;
  style.FrameRounding = 3;
  style.ScrollbarSize = 6;
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

}  // namespace lode::app
