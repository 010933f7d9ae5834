#include "client/core/cache/decode_job.h"

#include <exception>
#include <utility>

#include "client/core/lod/triangle_clusters.h"
#include "client/core/textures/tile.h"

namespace lode::core {

DecodeResult runDecodeJob(const DecodeJob& job) {
  DecodeResult result;
  result.blob = job.blob;
  result.use = job.use;
  try {
    if (job.use.kind == BlobKind::kTile) {
      TileImage image = decodeTile(job.bytes, job.image_size);
      if (job.with_tail) makeTail(image);
      result.image = std::make_shared<const TileImage>(std::move(image));
      return result;
    }
    Mesh decoded = decodePayload(job.bytes, job.step, job.expected);
    clusterTriangles(decoded);
    auto mesh = std::make_shared<const Mesh>(std::move(decoded));
    if (job.textures)
      result.footprint =
          std::make_shared<const TextureFootprint>(makeFootprint(*mesh, *job.textures, job.step));
    result.decoded = std::move(mesh);
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  return result;
}

}  // namespace lode::core
