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

/// Writes an sRGB PNG row by row as an AtomicFile. Needs memory for one row.
/// @param has_alpha  false omits the alpha channel. @throws Error kIo, and the exceptions of `fill`.
void writePng(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha, const FillRow& fill,
              OutputName name = OutputName::kTyped);

}  // namespace lode
