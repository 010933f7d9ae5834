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

/// A blob to decode outside the core, on any thread. A payload: decodePayload(), clusterTriangles(), and the
/// footprint if the texture set is known. A tile: decodeTile() and its tail.
struct DecodeJob {
  BlobRef blob;
  BlobUse use;
  std::vector<std::byte> bytes;
  double step = 1;
  PayloadExpectation expected;
  std::shared_ptr<const TextureSet> textures = nullptr;
  glm::uvec2 image_size{0};  ///< tiles only
  bool with_tail = false;    ///< for tiles of a coarsest level: see makeTail()
};

struct DecodeResult {
  BlobRef blob;
  BlobUse use;
  std::shared_ptr<const Mesh> decoded;     ///< payloads only; null on failure
  std::shared_ptr<const TileImage> image;  ///< tiles only; null on failure
  std::shared_ptr<const TextureFootprint> footprint;
  std::string failure;  ///< reason, on failure
};

/// Runs a job. Never throws: errors are in DecodeResult::failure.
DecodeResult runDecodeJob(const DecodeJob& job);

}  // namespace lode::core
