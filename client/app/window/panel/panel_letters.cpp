#include "client/app/window/panel/panel_letters.h"

#include <cstddef>

namespace lode::app {
namespace {

constexpr char32_t kLastOfLatin = 0x17f;
constexpr size_t kMostOthers = 4096;  ///< of a picture of letters that stays small

/// Bytes after the first of a letter. Source: RFC 3629, 3.
int following(unsigned char first) {
  if (first >= 0xf0 && first <= 0xf4) return 3;
  if (first >= 0xe0 && first < 0xf0) return 2;
  return first >= 0xc2 && first < 0xe0 ? 1 : 0;
}

}  // namespace

bool PanelLetters::see(std::string_view text) {
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

}  // namespace lode::app
