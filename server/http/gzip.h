#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lode::http {

/// Compresses bytes to the format gzip (RFC 1952). The result depends only on the bytes.
/// @throws Error kInternal if zlib fails, std::bad_alloc. Thread safe.
std::vector<std::byte> gzip(std::span<const std::byte> bytes);

}  // namespace lode::http
