#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/draco_codec.h"

namespace lode::tiles {

/// Bytes of a normal outside a Draco stream: three signed bytes and one padding byte, because glTF aligns
/// vertices to four bytes.
constexpr size_t kGlbNormalBytes = 4;

/// An image of a GLB, in a file of its own or inside the GLB.
struct GlbImage {
  std::string uri = {};                ///< relative reference; empty if the image is inside
  std::vector<std::byte> inside = {};  ///< JPEG or WebP file
  bool is_webp = false;
  bool repeats = false;   ///< the image repeats beyond its edges
  bool cuts_out = false;  ///< transparent texels are not drawn
};

/// Triangles of a GLB that show the same image.
struct GlbPart {
  GltfStream stream;
  std::vector<std::byte> normals;  ///< normals outside the stream, kGlbNormalBytes per vertex; may be empty
  uint64_t triangles = 0;
  std::array<glm::vec3, 2> bounds;  ///< least and greatest coordinates of the positions
  std::optional<uint32_t> image;    ///< index in GlbContent::images
};

struct GlbContent {
  std::vector<GlbPart> parts;
  std::vector<GlbImage> images;
};

/// Returns binary glTF 2.0 with the extension KHR_draco_mesh_compression. Each part is a primitive with a
/// matt, double-sided material. Normals outside a stream need KHR_mesh_quantization, WebP needs
/// EXT_texture_webp. The mesh is in the model frame, rotated from z up to y up; viewers of 3D Tiles rotate it
/// back. Thread safe.
std::vector<std::byte> encodeGlb(const GlbContent& content);

}  // namespace lode::tiles
