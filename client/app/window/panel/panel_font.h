#pragma once

#include <cstdint>
#include <set>
#include <string_view>
#include <vector>

namespace lode::app {

/// Collects the characters that the font atlas needs: Latin and all others that occurred in texts. An atlas
/// of all characters of a font would have tens of thousands. Pure.
class PanelCharacters {
 public:
  /// Adds the characters of a text. @param text  UTF-8; invalid bytes are skipped. @return whether any is
  /// new.
  bool add(std::string_view text);
  /// Returns character ranges up to `most` for Dear ImGui: pairs of first and last character, then a zero.
  template <typename Letter>
  std::vector<Letter> ranges(char32_t most) const {
    std::vector<Letter> ranges{0x20, 0x17f};
    for (const char32_t letter : others_)
      if (letter <= most) ranges.insert(ranges.end(), 2, static_cast<Letter>(letter));
    ranges.push_back(0);
    return ranges;
  }

 private:
  std::set<char32_t> others_;
};

/// Font size of the panel at scale 1.
constexpr float kTextPx = 15;

/// Sets Dear ImGui's font and spacing for a scale: DejaVu Sans if installed, else ImGui's own font, plus the
/// first installed of some East Asian fonts for missing characters. Call it between frames, after the OpenGL
/// backend is initialized.
void setPanelFont(float scale, const PanelCharacters& characters);

}  // namespace lode::app
