#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/image/image.h"

namespace lode::ingest {

/// What a picture's file announces.
struct ImageHeader {
  uint64_t width = 0, height = 0;  ///< pixels, up to kMaxTextureEdgePx each
  /// Of memory, at most: the texels with what their decoder takes beside them, or the next coarser level.
  uint64_t working_bytes = 0;
};

/// Of a JPEG, PNG or WebP file, told apart by its first bytes. Takes no memory for texels.
/// @throws Error kInput: no picture of these kinds, a damaged header, or a size above the limit. The message
/// begins with what is wrong. Thread safe.
ImageHeader readImageHeader(std::span<const std::byte> file);

/// Decodes a file of which readImageHeader() reads the header.
/// @param memory_bytes  to be used at most, the file's bytes not counted; checked before any is taken.
/// @param damage        receives what a decoder could not read of a picture that it gave all the same.
/// @throws Error kInput: as readImageHeader(), or a damaged picture; kLimit: it takes more memory. The
/// message begins with what is wrong. Thread safe.
Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage);

}  // namespace lode::ingest
