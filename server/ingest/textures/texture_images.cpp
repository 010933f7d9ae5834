#include "server/ingest/textures/texture_images.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>

#include "common/byte_size.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/io/texture_finder.h"
#include "common/printable.h"
#include "server/ingest/plan/memory_plan.h"

namespace lode::ingest {
namespace {

/// Returns the problem and remedy for an image that does not fit in memory.
std::string tooLarge(uint64_t needed, uint64_t memory_bytes) {
  return "needs " + byteSizeAtLeast(needed) + " of memory, but an image may use only " +
         describeBytes(memory_bytes) + " of --memory; raise it to " +
         byteSizeAtLeast(budgetForImage(needed)) + " or scale the image down";
}

std::string inPixels(const ImageHeader& header) {
  return std::to_string(header.width) + " x " + std::to_string(header.height) + " pixels";
}

/// Reads the header of an image, or sets `problem`.
void examine(TextureImage& image, uint64_t memory_bytes) {
  try {
    const std::vector<std::byte> file = readImageFile(image.path, memory_bytes);
    image.file_bytes = file.size();
    image.header = readImageHeader(file);
  } catch (const Error& error) {
    image.problem = error.what();
    image.needs_memory = error.code() == ErrorCode::kLimit;
    return;
  }
  if (image.memoryBytes() <= memory_bytes) return;
  image.problem = "has " + inPixels(image.header) + " and " + tooLarge(image.memoryBytes(), memory_bytes);
  image.needs_memory = true;
  image.header = {};
}

uint64_t tilesOf(const TextureImage& image) {
  if (!image.problem.empty()) return 0;
  return tileCount(lode::Texture{
      {}, static_cast<uint32_t>(image.header.width), static_cast<uint32_t>(image.header.height), {}});
}

void checkTiles(const std::filesystem::path& ply, const std::vector<TextureImage>& images) {
  uint64_t tiles = 0;
  for (const TextureImage& image : images) tiles += tilesOf(image);
  if (tiles <= kMaxTextureTiles) return;
  const auto largest = std::max_element(images.begin(), images.end(),
                                        [](const auto& a, const auto& b) { return tilesOf(a) < tilesOf(b); });
  throw Error(ErrorCode::kInput, ply.string() + ": its texture images need " + std::to_string(tiles) +
                                     " tiles; the limit is " + std::to_string(kMaxTextureTiles) +
                                     "; scale them down (the largest, " + quotedText(largest->name, 4096) +
                                     ", has " + inPixels(largest->header) + ") or split the model");
}

}  // namespace

std::vector<TextureImage> surveyTextures(std::span<const NamedImage> names,
                                         const std::filesystem::path& textures_folder,
                                         uint64_t memory_bytes) {
  if (names.size() > kMaxTextures)
    throw Error(ErrorCode::kInput, names.front().ply.string() + ": " + std::to_string(names.size()) +
                                       " texture files; the limit is " + std::to_string(kMaxTextures) +
                                       "; merge some of them");
  std::vector<TextureImage> images;
  std::optional<TextureFinder> finder;
  for (const auto& [ply, name] : names) {
    if (images.empty() || images.back().ply != ply) finder.emplace(ply, textures_folder);
    TextureFile file = finder->find(name);
    images.push_back({ply, name, std::move(file.path), std::move(file.problem), false, 0, {}});
    if (images.back().problem.empty()) examine(images.back(), memory_bytes);
  }
  if (!images.empty()) checkTiles(images.front().ply, images);
  return images;
}

std::vector<std::byte> readImageFile(const std::filesystem::path& path, uint64_t memory_bytes) {
  constexpr const char* kUnreadable = "cannot be read; check the file and its permissions";
  std::error_code failed;
  const uint64_t size = std::filesystem::file_size(path, failed);
  if (failed) throw Error(ErrorCode::kInput, kUnreadable);
  if (size > memory_bytes) throw Error(ErrorCode::kLimit, tooLarge(size, memory_bytes));
  std::vector<std::byte> bytes(size);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw Error(ErrorCode::kInput, kUnreadable);
  return bytes;
}

Image readImage(const std::filesystem::path& path, uint64_t memory_bytes, std::string& damage) {
  const std::vector<std::byte> file = readImageFile(path, memory_bytes);
  Image image = decodeImage(file, memory_bytes - file.size(), damage);
  if (!damage.empty()) damage = "is damaged (" + damage + "); the readable part is used";
  return image;
}

std::string textureInWords(const std::filesystem::path& ply, const std::string& name) {
  return ply.string() + ": texture " + quotedText(name, 4096);
}

}  // namespace lode::ingest
