#pragma once

#include <string_view>

namespace lode {

/// Whether a text is UTF-8 without control characters and marks of direction: it may be shown, and end up on
/// a terminal. Thread safe.
bool isPrintableUtf8(std::string_view text) noexcept;

}  // namespace lode
