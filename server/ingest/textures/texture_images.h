#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "server/ingest/textures/image_decoder.h"

namespace lode::ingest {

/// What is wrong with a model that has texture coordinates and names no image.
constexpr const char* kNoTextureFile =
    "texture coordinates, but no comment TextureFile names a texture; add one to the header";

/// Where the image of a `comment TextureFile` is.
struct TextureFile {
  std::filesystem::path path;
  std::string problem;  ///< why there is none to be read, with a remedy; empty if there is
};

/// Looks for an image in the PLY file's folder or below, then, where the PLY is a link, in that of the file
/// that it leads to; links of images are followed, but not out of these. Thread safe.
TextureFile findTexture(const std::filesystem::path& ply, const std::string& name);

/// An image that a model names, as far as its header tells.
struct TextureImage {
  std::string name;            ///< as the model's file has it
  std::filesystem::path path;  ///< empty: there is none
  std::string problem;         ///< why it is left out, with a remedy; empty if it is not
  bool needs_memory = false;   ///< the problem is this build's budget, from which no store may follow
  uint64_t file_bytes = 0;
  ImageHeader header;  ///< no pixels if there is a problem

  /// Of memory, that decoding it and making its levels take.
  uint64_t memoryBytes() const noexcept { return file_bytes + header.working_bytes; }
};

/// Finds the images and reads their headers; takes the memory of one file at a time.
/// @param memory_bytes  that an image may take (MemoryPlan::image_bytes); one that takes more has a problem.
/// @throws Error kInput if there are more images, or tiles of all together, than a store takes. Thread safe.
std::vector<TextureImage> surveyTextures(const std::filesystem::path& ply, std::span<const std::string> names,
                                         uint64_t memory_bytes);

/// The bytes of an image's file. @throws Error kInput if they cannot be read, kLimit if there are more than
/// `memory_bytes`; the message begins with what is wrong. Thread safe.
std::vector<std::byte> readImageFile(const std::filesystem::path& path, uint64_t memory_bytes);

/// Decodes an image's file, within `memory_bytes` for both. @param damage  receives what could not be read of
/// one that can be shown all the same, in words after textureInWords(). @throws Error as readImageFile() and
/// decodeImage(). Thread safe.
Image readImage(const std::filesystem::path& path, uint64_t memory_bytes, std::string& damage);

/// "FILE.ply: texture 'NAME'", as a warning about an image begins.
std::string textureInWords(const std::filesystem::path& ply, const std::string& name);

}  // namespace lode::ingest
