#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace lode::ingest {

/// A picture in memory: texels by rows from the top, sRGB with straight alpha.
struct Image {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;

  bool operator==(const Image&) const = default;
  const glm::u8vec4& at(uint32_t x, uint32_t y) const { return texels[size_t{y} * size.x + x]; }
};

/// Decodes a JPEG, PNG or WebP file, told apart by its first bytes. Nothing is taken for texels before the
/// size that the file announces was checked.
/// @param memory_bytes  to be used at most, the file's bytes not counted.
/// @param damage        receives what a decoder could not read of a picture that it gave all the same.
/// @throws Error kInput: no picture of these kinds, or a damaged one; kLimit: it takes more memory. The
/// message begins with what is wrong. Thread safe.
Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage);

/// The next coarser level of a picture: of ceil(size / 2) texels each way, each the mean of what it covers,
/// in linear light, colours weighted by their alpha. Thread safe.
Image halved(const Image& image);

/// A part of a picture that goes on beyond its rims by repetition. Thread safe.
Image cutOut(const Image& image, glm::ivec2 first, glm::uvec2 size);

}  // namespace lode::ingest
