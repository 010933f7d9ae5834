#pragma once

#include <cstdint>
#include <set>
#include <string_view>
#include <vector>

namespace lode::app {

/// Which letters the panel's typeface is asked for: those of Latin, and whatever else a text has had. All
/// that a font may have would be a picture of tens of thousands. Pure.
class PanelLetters {
 public:
  /// @param text  in UTF-8; what is none of it is left out. @return whether it has letters that are new.
  bool see(std::string_view text);
  /// First and last letters of ranges in turn, each up to `most`, and a zero: as Dear ImGui takes them.
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

}  // namespace lode::app
