#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace lode::ingest {

/// An image, by the PLY file that names it and the name there.
struct NamedImage {
  std::filesystem::path ply;
  std::string name;
};

/// Returns the images of one PLY file.
std::vector<NamedImage> imagesOf(const std::filesystem::path& ply, std::span<const std::string> names);

/// The images that the input files of a model name, each once.
struct InputImages {
  std::vector<NamedImage> images;
  /// For each input file, the index in `images` of each image that the file names.
  std::vector<std::vector<uint16_t>> of_file;
};

/// Lists the images in the headers of PLY files. Names in several files that lead to the same file on disk
/// become one image.
/// @param textures_folder  folder of --textures; empty: none. @throws Error as readPlyHeader() does; kInput
/// if there are more images than a store can have.
InputImages listImages(std::span<const std::filesystem::path> inputs,
                       const std::filesystem::path& textures_folder);

}  // namespace lode::ingest
