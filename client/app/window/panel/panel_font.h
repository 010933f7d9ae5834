#pragma once

#include <cstdint>
#include <set>
#include <string_view>
#include <vector>

namespace lode::app {

/// Collects the characters that the font atlas needs: Latin, and all other characters that have occurred in
/// texts. The atlas does not contain all characters of a font, because a font can have tens of thousands.
/// Pure.
class PanelCharacters {
 public:
  /// Adds the characters of a text. @param text  UTF-8; invalid bytes are skipped.
  /// @return true if at least one character is new.
  bool add(std::string_view text);
  /// Returns the ranges of characters up to `most`, in the format of Dear ImGui: pairs of a first and a last
  /// character, then a zero.
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

/// Sets the font and spacing of Dear ImGui for a scale. Uses DejaVu Sans if it is installed, else ImGui's own
/// font. Takes characters that this font lacks from the first installed font of a list of East Asian fonts.
/// Call it between frames, after the OpenGL backend is initialized.
void setPanelFont(float scale, const PanelCharacters& characters);

}  // namespace lode::app
