#include "server/ingest/textures/texture_images.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>

#include "common/byte_size.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/ply/ply_input.h"

namespace lode::ingest {
namespace {

bool isInside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// Returns a text about an image that is too large for the memory, with the remedy.
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

constexpr const char* kOutside = "is outside the PLY file's folder; move it there and name it without a path";

/// Returns the folders that can contain images of a PLY file: the folder of the file and, if the file is a
/// link, the folder of the link's target.
std::vector<std::filesystem::path> foldersOf(const std::filesystem::path& ply) {
  std::vector<std::filesystem::path> folders;
  std::error_code failed;
  const auto add = [&](const std::filesystem::path& file) {
    std::filesystem::path folder =
        std::filesystem::canonical(file.has_parent_path() ? file.parent_path() : ".", failed);
    if (!failed && std::find(folders.begin(), folders.end(), folder) == folders.end())
      folders.push_back(std::move(folder));
  };
  add(ply);
  if (const std::filesystem::path target = std::filesystem::canonical(ply, failed); !failed) add(target);
  return folders;
}

struct FoundTexture {
  bool exists = false;
  TextureFile file;
};

FoundTexture findIn(const std::filesystem::path& folder, const std::filesystem::path& named) {
  std::error_code failed;
  const std::filesystem::path path = std::filesystem::canonical(folder / named, failed);
  if (failed || !std::filesystem::exists(path, failed)) return {};
  if (!isInside(path, folder))
    return {true,
            {{},
             named.is_absolute() ? kOutside
                                 : "is a link out of the PLY file's folder; copy the image itself there"}};
  if (!std::filesystem::is_regular_file(path, failed))
    return {true, {{}, "is not a file; replace it by the image"}};
  return {true, {path, {}}};
}

std::string notFound(const std::vector<std::filesystem::path>& folders) {
  std::string words = "was not found; put it into the PLY file's folder";
  for (size_t i = 0; i < folders.size(); ++i)
    words += (i == 0 ? ", " : ", or into the folder of its link's target, ") +
             quotedText(folders[i].string(), 4096);
  return words;
}

}  // namespace

TextureFile findTexture(const std::filesystem::path& ply, const std::string& name) {
  const std::filesystem::path named(name);
  const auto is_up = [](const std::filesystem::path& part) { return part == ".."; };
  if (std::any_of(named.begin(), named.end(), is_up)) return {{}, kOutside};
  const std::vector<std::filesystem::path> folders = foldersOf(ply);
  std::optional<std::string> problem;
  for (const std::filesystem::path& folder : folders) {
    FoundTexture looked = findIn(folder, named);
    if (looked.exists && looked.file.problem.empty()) return looked.file;
    if (looked.exists && !problem) problem = looked.file.problem;
  }
  if (problem) return {{}, *problem};
  if (named.is_absolute()) return {{}, kOutside};
  if (name.find('\\') != std::string::npos)
    return {{},
            "has a path of another system; put it into the PLY file's folder and name it without a "
            "path"};
  return {{}, notFound(folders)};
}

std::vector<TextureImage> surveyTextures(const std::filesystem::path& ply, std::span<const std::string> names,
                                         uint64_t memory_bytes) {
  if (names.size() > kMaxTextures)
    throw Error(ErrorCode::kInput, ply.string() + ": " + std::to_string(names.size()) +
                                       " texture files; the limit is " + std::to_string(kMaxTextures) +
                                       "; merge some of them");
  std::vector<TextureImage> images;
  for (const std::string& name : names) {
    TextureFile file = findTexture(ply, name);
    images.push_back({name, std::move(file.path), std::move(file.problem), false, 0, {}});
    if (images.back().problem.empty()) examine(images.back(), memory_bytes);
  }
  checkTiles(ply, images);
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
