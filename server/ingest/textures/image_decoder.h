#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/image/image.h"

namespace lode::ingest {

/// Header of an image file.
struct ImageHeader {
  uint64_t width = 0, height = 0;  ///< size in pixels, at most kMaxTextureEdgePx each
  /// Upper bound on the memory for decoding the image, and for computing the next coarser level.
  uint64_t working_bytes = 0;
};

/// Reads the header of a JPEG, PNG or WebP file, recognized by its first bytes. Allocates no texels.
/// @throws Error kInput if the file has another format, its header is damaged, or the size is above the
/// limit. The message begins with the problem, without the file's name. Thread safe.
ImageHeader readImageHeader(std::span<const std::byte> file);

/// Decodes an image file.
/// @param memory_bytes  limit on the memory in addition to the file's bytes; checked before any allocation.
/// @param damage        receives the decoder's warning about an image that is damaged but usable.
/// @throws Error kInput as readImageHeader() does, or if the image is damaged; kLimit if the memory does not
/// suffice. The message begins with the problem. Thread safe.
Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage);

/// Returns the number of pixels that decodeCoarsely() computes. @throws Error as readImageHeader() does.
uint64_t coarsePixels(std::span<const std::byte> file);
/// Decodes a JPEG at 1/8 of its width and height, which takes less time. Decodes other files at full size.
/// @throws Error as decodeImage() does. Thread safe.
Image decodeCoarsely(std::span<const std::byte> file, uint64_t memory_bytes);

}  // namespace lode::ingest
