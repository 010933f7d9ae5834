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

/// A blob to decode, on any thread. For the payload of a mesh, runDecodeJob() calls decodePayload() and
/// clusterTriangles(), and computes the texture footprint if the texture set is known. For a texture tile, it
/// calls decodeTile() and, if with_tail is true, makeTail().
struct DecodeJob {
  BlobRef blob;
  BlobUse use;
  std::vector<std::byte> bytes;
  double step = 1;
  PayloadExpectation expected;
  std::shared_ptr<const TextureSet> textures = nullptr;
  glm::uvec2 image_size{0};  ///< size of a tile's image; unused for payloads
  bool with_tail = false;    ///< true for the coarsest stored level of a texture: see makeTail()
};

struct DecodeResult {
  BlobRef blob;
  BlobUse use;
  std::shared_ptr<const Mesh> decoded;     ///< mesh of a payload; null for tiles and on failure
  std::shared_ptr<const TileImage> image;  ///< image of a tile; null for payloads and on failure
  std::shared_ptr<const TextureFootprint> footprint;
  std::string failure;  ///< reason why decoding failed; empty on success
};

/// Runs a job. Never throws; reports errors in DecodeResult::failure.
DecodeResult runDecodeJob(const DecodeJob& job);

}  // namespace lode::core
