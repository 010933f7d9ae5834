// Decodes texture sets. A set that decodes must encode to the same bytes, and each of its tiles must have an
// index and a size.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "common/codec/texture_set.h"
#include "common/error.h"

namespace {

using namespace lode;

void require(bool condition) {
  if (!condition) std::abort();
}

void checkPlaces(const Texture& texture) {
  size_t place = 0;
  for (uint32_t level = levelCount(texture); level-- > 0;)
    for (uint32_t y = 0; y < tilesDown(texture, level); ++y)
      for (uint32_t x = 0; x < tilesAcross(texture, level); ++x) {
        require(tileIndex(texture, level, x, y) == place++);
        const glm::uvec2 inner = tileInnerSize(texture, level, x, y);
        require(inner.x > 0 && inner.y > 0 && inner.x <= kTileInnerPx && inner.y <= kTileInnerPx);
      }
  require(place == texture.tiles.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    const TextureSet set = decodeTextureSet(bytes);
    require(std::ranges::equal(encodeTextureSet(set), bytes));
    for (const Texture& texture : set.textures) checkPlaces(texture);
  } catch (const Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
  return 0;
}
