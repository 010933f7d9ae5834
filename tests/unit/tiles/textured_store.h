#pragma once

#include <vector>

#include "server/store/reader.h"
#include "tests/support/synthetic_store.h"
#include "tests/support/texture_images.h"
#include "tests/support/work_folder.h"

namespace lode::test {

/// Returns a colour that is unique to a texel.
inline glm::u8vec4 texelAt(uint32_t x, uint32_t y) {
  return {x & 255, y & 255, (x >> 8 & 15) | (y >> 8 & 15) << 4, 255};
}

/// A store with lossless texture tiles and an arbitrary model.
class TexturedStore {
 public:
  explicit TexturedStore(const std::vector<TextureImages>& images, int32_t uv_scale_exponent = 0)
      : TexturedStore(images, uv_scale_exponent, makeModel(makeSphere(8, 6))) {}
  TexturedStore(const std::vector<TextureImages>& images, int32_t uv_scale_exponent, SyntheticModel model)
      : reader_(write(images, uv_scale_exponent, model)) {}

  const store::Reader& reader() const { return reader_; }

 private:
  store::Reader write(const std::vector<TextureImages>& images, int32_t uv_scale_exponent,
                      SyntheticModel& model) {
    writeStore(folder_ / "m.lode", model, [&](store::Writer& writer) {
      TextureSet set;
      set.uv_scale_exponent = uv_scale_exponent;
      for (const TextureImages& image : images) {
        Texture& texture = set.textures.emplace_back(image.texture());
        texture.tiles.clear();
        image.forEachTile([&](uint32_t level, uint32_t x, uint32_t y) {
          texture.tiles.push_back(writer.addBlob(webpOf(image.tile(level, x, y))));
        });
      }
      return set;
    });
    return store::Reader(folder_ / "m.lode");
  }

  WorkFolder folder_;
  store::Reader reader_;
};

}  // namespace lode::test
