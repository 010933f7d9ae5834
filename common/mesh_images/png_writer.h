#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include <glm/glm.hpp>

namespace lode {

/// Fills a row of an image, from the top.
using FillRow = std::function<void(uint32_t y, std::span<glm::u8vec4> row)>;

/// Writes a PNG file row by row, sRGB, that appears under its name when it is whole. Memory: one row.
/// @param has_alpha  else that channel is left out. @throws Error kIo, and what `fill` throws.
void writePng(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha, const FillRow& fill);

}  // namespace lode
