#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/core/cache/decode_job.h"

/// Messages between the page's main thread and its decode workers, which share no memory. Integers are
/// little-endian, as in all WebAssembly. Thread safe.
namespace lode::web {

using Bytes = std::vector<std::byte>;

/// A decode job without the parts that only the main thread uses.
struct JobMessage {
  uint32_t number = 0;  ///< number that the result repeats
  core::DecodeJob job;
};

/// @param number  number by which the main thread finds the job of a result.
Bytes encodeJob(uint32_t number, const core::DecodeJob& job);

/// Decodes a job. The blob reference and the mesh key of the job are empty. The texture set has the sizes of
/// the textures, but no tiles.
/// @throws Error kFormat if the message is damaged.
JobMessage decodeJob(std::span<const std::byte> message);

/// Returns the result of a tile's job from texels that the browser has decoded.
/// @param texels  rows of RGBA texels from the top; empty if the browser cannot decode the image.
core::DecodeResult takeImage(const core::DecodeJob& job, std::span<const uint8_t> texels, glm::uvec2 size);

/// Encodes the result of a job.
Bytes encodeResult(uint32_t number, const core::DecodeResult& result);

struct ResultMessage {
  uint32_t number = 0;
  core::DecodeResult result;  ///< the blob reference and the use are empty
};

/// @throws Error kFormat if the message is damaged.
ResultMessage decodeResult(std::span<const std::byte> message);

}  // namespace lode::web
