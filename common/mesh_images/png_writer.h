#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include <glm/glm.hpp>

#include "common/io/output_target.h"

namespace lode {

/// A function that fills row y of an image, counted from the top.
using FillRow = std::function<void(uint32_t y, std::span<glm::u8vec4> row)>;

/// Writes an sRGB PNG row by row through an AtomicFile. Keeps one row in memory.
/// @param has_alpha  if false, the file has no alpha channel. @throws Error kIo, and the exceptions of
/// `fill`.
void writePng(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha, const FillRow& fill,
              OutputName name = OutputName::kTyped);

}  // namespace lode
