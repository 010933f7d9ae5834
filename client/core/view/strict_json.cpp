#include "client/core/view/strict_json.h"

#include <algorithm>

namespace lode::core {

std::string placeIn(std::string_view text, size_t bytes) {
  const std::string_view before = text.substr(0, bytes > 0 ? bytes - 1 : 0);
  const auto line = 1 + std::ranges::count(before, '\n');
  const size_t column = before.size() - (before.rfind('\n') + 1);  // npos + 1 is 0
  return " at line " + std::to_string(line) + ", column " + std::to_string(column + 1);
}

}  // namespace lode::core
