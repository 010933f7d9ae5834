#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lode {

/// Whether a text is UTF-8 without control characters and marks of direction: it may be shown, and end up on
/// a terminal. Thread safe.
bool isPrintableUtf8(std::string_view text) noexcept;

/// "1 vertex", "2 vertices". @param several  by default `one` with an s.
std::string counted(uint64_t count, std::string_view one, std::string_view several = {});

}  // namespace lode
