#include "client/app/window/panel/panel_font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <vector>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace lode::app {
namespace {

constexpr char32_t kLastOfLatin = 0x17f;
/// Largest number of non-Latin characters in the font atlas. The limit keeps the atlas small.
constexpr size_t kMostOthers = 4096;

/// Returns the number of bytes that follow the first byte of a UTF-8 character. Source: RFC 3629, section 3.
int following(unsigned char first) {
  if (first >= 0xf0 && first <= 0xf4) return 3;
  if (first >= 0xe0 && first < 0xf0) return 2;
  return first >= 0xc2 && first < 0xe0 ? 1 : 0;
}

// In Debian's package fonts-dejavu-core.
constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
/// East Asian fonts. Their packages in Debian are fonts-noto-cjk, fonts-droid-fallback, fonts-wqy-microhei,
/// fonts-wqy-zenhei and fonts-ipafont-gothic.
constexpr std::array<const char*, 5> kOtherFonts{"/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                                                 "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
                                                 "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
                                                 "/usr/share/fonts/truetype/wqy/wqy-zenhei.ttc",
                                                 "/usr/share/fonts/opentype/ipafont-gothic/ipag.ttf"};
constexpr size_t kPlainRanges = 3;  ///< size of PanelCharacters::ranges() if all characters are Latin
/// Size of ImGui's own font, a bitmap that is legible only at multiples of this size.
constexpr float kOwnTextPx = 13;

}  // namespace

bool PanelCharacters::add(std::string_view text) {
  const size_t before = others_.size();
  for (size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at++]);
    const int more = following(first);
    char32_t letter = more == 0 ? first : first & (0x3f >> more);
    int taken = 0;
    for (; taken < more && at < text.size(); ++taken, ++at) {
      const auto next = static_cast<unsigned char>(text[at]);
      if ((next & 0xc0) != 0x80) break;
      letter = letter << 6 | (next & 0x3f);
    }
    if (more > 0 && taken == more && letter > kLastOfLatin && others_.size() < kMostOthers)
      others_.insert(letter);
  }
  return others_.size() > before;
}

void setPanelFont(float scale, const PanelCharacters& characters) {
  const std::vector<ImWchar> ranges = characters.ranges<ImWchar>(IM_UNICODE_CODEPOINT_MAX);
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
    merged.MergeMode = true;  // the second font adds only characters that the first font lacks
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
