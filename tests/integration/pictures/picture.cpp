#include "tests/integration/pictures/picture.h"

#include <algorithm>
#include <cstdlib>
#include <set>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace lode::test {

Picture::Picture(const std::filesystem::path& file) {
  int channels = 0;
  stbi_uc* const read = stbi_load(file.c_str(), &width_px, &height_px, &channels, 3);
  if (read == nullptr) return;
  pixels.assign(read, read + static_cast<size_t>(width_px) * height_px * 3);
  stbi_image_free(read);
}

double Picture::covered(int left, int top) const {
  constexpr int kDither = 8;
  size_t drawn = 0;
  for (int y = top; y < height_px; ++y)
    for (int x = left; x < width_px; ++x) {
      int difference = 0;
      for (int c = 0; c < 3; ++c)
        difference = std::max(difference, std::abs(pixel(x, y)[c] - pixel(width_px - 1, y)[c]));
      drawn += difference > kDither;
    }
  return static_cast<double>(drawn) / ((width_px - left) * (height_px - top));
}

size_t Picture::shades() const {
  std::set<uint8_t> seen;
  for (int x = 0; x < width_px; ++x) seen.insert(*pixel(x, height_px / 2));
  return seen.size();
}

void writePicture(const std::filesystem::path& file, int width_px, int height_px,
                  const std::vector<uint8_t>& pixels) {
  if (stbi_write_png(file.c_str(), width_px, height_px, 3, pixels.data(), width_px * 3) == 0) std::abort();
}

bool cannotDraw(const Outcome& outcome, const char* why) {
  return outcome.status == 1 && outcome.err.find(why) != std::string::npos;
}

}  // namespace lode::test
