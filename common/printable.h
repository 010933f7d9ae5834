#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace lode {

/// Returns true if a text is valid UTF-8 without control characters and directional marks, so that it is safe
/// to print on a terminal. Thread safe.
bool isPrintableUtf8(std::string_view text) noexcept;

/// Returns "1 vertex" or "2 vertices". @param several  plural; by default `one` with an s.
std::string counted(uint64_t count, std::string_view one, std::string_view several = {});

/// Quotes at most max_bytes of a text for a message. Escapes ASCII control characters as \xNN.
std::string quotedText(std::string_view text, size_t max_bytes = 48);

/// Prints "PROGRAM: MESSAGE" as one line on stderr.
void printOnOneLine(std::string_view program, std::string message);

}  // namespace lode
