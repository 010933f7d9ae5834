#include "client/render/gl/image.h"

#include <cstring>
#include <span>

#include <glm/glm.hpp>

#include "common/mesh_images/png_writer.h"

namespace lode::render {

void writePng(const std::filesystem::path& path, const Image& image, OutputName name) {
  const auto fill = [&](uint32_t y, std::span<glm::u8vec4> row) {
    std::memcpy(row.data(), image.pixel(0, y), row.size_bytes());
  };
  lode::writePng(path, {image.width_px, image.height_px}, false, fill, name);
}

}  // namespace lode::render
