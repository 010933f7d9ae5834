#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lode::http {

constexpr int kGzipQuickly = 6;  ///< zlib's default level
constexpr int kGzipMost = 9;     ///< level for contents that are compressed once and sent often

/// Compresses bytes to the format gzip (RFC 1952). The result depends only on the bytes and the level.
/// @throws Error kInternal if zlib fails, std::bad_alloc. Thread safe.
std::vector<std::byte> gzip(std::span<const std::byte> bytes, int level = kGzipQuickly);

}  // namespace lode::http
