#pragma once

#include <filesystem>

#include "common/io/image_files.h"
#include "server/store/reader.h"

namespace lode::store {

/// Writes the images of a store's textures, at full size and without further loss, as PNG files beside a
/// mesh's file: STEM_NAME.png, where STEM is that file's and NAME the texture's without folders. Memory: one
/// row of tiles.
/// @throws Error kIo, kFormat, kLimit.
ImageFiles exportTextures(const Reader& reader, const std::filesystem::path& mesh);

}  // namespace lode::store
