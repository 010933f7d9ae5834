#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace lode::web {

/// Returns the SHA-256 of bytes, for programs without OpenSSL. Thread safe.
/// Source: NIST, FIPS 180-4, Secure Hash Standard, 2015.
std::array<std::byte, 32> sha256(std::span<const std::byte> bytes) noexcept;

}  // namespace lode::web
