#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/image.h"

namespace lode::ingest {

/// Decodes a JPEG, PNG or WebP file, told apart by its first bytes. Nothing is taken for texels before the
/// size that the file announces was checked.
/// @param memory_bytes  to be used at most, the file's bytes not counted.
/// @param damage        receives what a decoder could not read of a picture that it gave all the same.
/// @throws Error kInput: no picture of these kinds, or a damaged one; kLimit: it takes more memory. The
/// message begins with what is wrong. Thread safe.
Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage);

}  // namespace lode::ingest
