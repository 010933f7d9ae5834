#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/codec/draco_codec.h"
#include "common/codec/texture_set.h"
#include "common/mesh.h"
#include "server/tiles/atlas.h"
#include "server/tiles/texture_levels.h"

namespace lode::tiles {

/// A whole level of a texture, as an image that tiles share.
struct SharedImage {
  uint32_t texture = 0, level = 0;

  auto operator<=>(const SharedImage&) const = default;
};

/// Triangles of an LOD that show the same image.
struct TexturedPart {
  enum class Source { kNone, kAtlas, kShared };

  Mesh mesh;  ///< mesh whose texture coordinates are codes of `coordinates`
  Source source = Source::kNone;
  GltfCoordinates coordinates;  ///< not set without an image
  SharedImage shared;           ///< set for kShared
};

/// An LOD, divided by images. A texel is at most as large as the LOD's error, unless the image would exceed
/// kMostImagePx. At an error of one pixel, a texel therefore covers at most one pixel.
struct TexturedLod {
  std::vector<TexturedPart> parts;  ///< in the order kNone, kAtlas, kShared by texture; none is empty
  std::optional<Atlas> atlas;
};

/// Chooses an image for each chart of an LOD and rewrites the texture coordinates for this image. Most charts
/// go into an atlas of this LOD. If the charts of a texture repeat the image or need at least half of it,
/// they use a whole level, which LODs share.
/// @param error_model  the larger of the LOD's error and appearance error, in model units; 0 selects the
/// texels of the input.
/// @throws Error as TextureLevels::part(). Deterministic.
TexturedLod textureLod(const Mesh& mesh, const TextureSet& textures, double step, double error_model,
                       TextureLevels& levels);

}  // namespace lode::tiles
