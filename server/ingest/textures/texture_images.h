#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "server/ingest/soup/input_images.h"
#include "server/ingest/textures/image_decoder.h"

namespace lode::ingest {

/// Text of the warning about a model that has texture coordinates but names no image.
constexpr const char* kNoTextureFile =
    "has texture coordinates, but its header names no image; add a line: comment TextureFile NAME";

/// An image that a model names, and its header.
struct TextureImage {
  std::filesystem::path ply;   ///< PLY file that names the image
  std::string name;            ///< name as written in the PLY file
  std::filesystem::path path;  ///< path of the image; empty if no file was found
  /// Reason why the image cannot be used, with the remedy; empty if the image can be used.
  std::string problem;
  bool needs_memory = false;  ///< true if more memory would solve the problem
  uint64_t file_bytes = 0;
  ImageHeader header;  ///< header of the image; empty if the image has a problem

  /// Returns the memory that decoding the image and computing its levels takes.
  uint64_t memoryBytes() const noexcept { return file_bytes + header.working_bytes; }
};

/// Finds the images with a TextureFinder and reads their headers. Only one file is in memory at a time.
/// @param textures_folder  folder of --textures; empty: none.
/// @param memory_bytes  limit per image (MemoryPlan::image_bytes). An image that needs more gets a `problem`.
/// @throws Error kInput if the number of images or of their tiles exceeds a store's limit. Thread safe.
std::vector<TextureImage> surveyTextures(std::span<const NamedImage> names,
                                         const std::filesystem::path& textures_folder, uint64_t memory_bytes);

/// Reads the bytes of an image file. @throws Error kInput if the file cannot be read, kLimit if the file is
/// larger than `memory_bytes`. The message begins with the problem. Thread safe.
std::vector<std::byte> readImageFile(const std::filesystem::path& path, uint64_t memory_bytes);

/// Reads and decodes an image file within `memory_bytes`. @param damage  receives a warning if the image is
/// damaged but usable; the text continues a message that begins with textureInWords(). @throws Error as
/// readImageFile() and decodeImage() do. Thread safe.
Image readImage(const std::filesystem::path& path, uint64_t memory_bytes, std::string& damage);

/// Returns "FILE.ply: texture 'NAME'", the beginning of messages about an image.
std::string textureInWords(const std::filesystem::path& ply, const std::string& name);

}  // namespace lode::ingest
