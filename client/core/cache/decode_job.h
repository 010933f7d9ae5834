#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "client/core/lod/request.h"
#include "client/core/textures/texture_footprint.h"
#include "common/codec/draco_codec.h"
#include "common/image/tile_image.h"

namespace lode::core {

/// A payload to be decoded outside the core, on any thread: decodePayload(bytes, step, expected), its
/// triangles in clusters, and the footprint of the mesh where textures are known; or a tile:
/// decodeTile(bytes, image_size), and its tail.
struct DecodeJob {
  BlobRef blob;
  BlobUse use;
  std::vector<std::byte> bytes;
  double step = 1;
  PayloadExpectation expected;
  std::shared_ptr<const TextureSet> textures = nullptr;
  glm::uvec2 image_size{0};  ///< of a tile
  bool with_tail = false;    ///< it is a coarsest level: see makeTail()
};

struct DecodeResult {
  BlobRef blob;
  BlobUse use;
  std::shared_ptr<const Mesh> decoded;     ///< of a payload; null if it failed
  std::shared_ptr<const TileImage> image;  ///< of a tile; null if it failed
  std::shared_ptr<const TextureFootprint> footprint;
  std::string failure;  ///< why it failed
};

/// Runs a job; never throws.
DecodeResult runDecodeJob(const DecodeJob& job);

}  // namespace lode::core
