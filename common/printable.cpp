#include "common/printable.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace lode {

namespace {

/// Returns true for marks that change the direction of the text around them. Such marks could disguise a
/// name.
bool turnsText(uint32_t code) {
  return code == 0x61C || code == 0x200E || code == 0x200F || (code >= 0x202A && code <= 0x202E) ||
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

bool isPrintableUtf8(std::string_view text) noexcept {
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    const auto lead = static_cast<uint8_t>(*at);
    if (lead < 0x20 || lead == 0x7F) return false;
    const int length = lead < 0x80                   ? 1
                       : lead >= 0xC2 && lead < 0xE0 ? 2
                       : lead >> 4 == 0xE            ? 3
                       : lead >= 0xF0 && lead < 0xF5 ? 4
                                                     : 0;
    if (length == 0 || end - at < length) return false;
    uint32_t code = length == 1 ? lead : lead & (0x7Fu >> length);
    for (int i = 1; i < length; ++i) {
      const auto next = static_cast<uint8_t>(at[i]);
      if ((next & 0xC0) != 0x80) return false;
      code = code << 6 | (next & 0x3F);
    }
    const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    const bool surrogate = code >= 0xD800 && code < 0xE000;
    const bool control = code >= 0x80 && code < 0xA0;
    if (overlong || surrogate || control || turnsText(code) || code > 0x10FFFF) return false;
    at += length;
  }
  return true;
}

std::string counted(uint64_t count, std::string_view one, std::string_view several) {
  std::string text = std::to_string(count) + " ";
  if (count == 1 || several.empty()) text += one;
  if (count != 1) text += several.empty() ? "s" : several;
  return text;
}

std::string quotedText(std::string_view text, size_t max_bytes) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string result = "'";
  for (const char c : text.substr(0, max_bytes)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      result += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
    } else {
      result += c;
    }
  }
  return result + (text.size() > max_bytes ? "...'" : "'");
}

void printOnOneLine(std::string_view program, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "%.*s: %s\n", static_cast<int>(program.size()), program.data(), message.c_str());
}

}  // namespace lode
