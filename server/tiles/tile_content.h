#pragma once

#include <functional>
#include <string>

#include "common/codec/texture_set.h"
#include "server/store/export.h"
#include "server/tiles/glb.h"
#include "server/tiles/texture_levels.h"
#include "server/tiles/tile_textures.h"

namespace lode::tiles {

/// Quality of the lossy images of a tileset. Lower than a store's, because a tileset has more texels than a
/// view needs (docs/decisions/0032-tile-textures.md).
constexpr int kImageQuality = 85;

/// Returns the GLB of an LOD without images. The Draco stream is the payload itself, except for LODs with
/// colours: glTF requires linear colours, so their streams are encoded again (encodeForGltf()). If the stream
/// has no normals, the GLB stores them after the stream. The result depends only on the payload.
/// @param lod   an LOD with triangles.
/// @param step  step of the lattice.
/// @throws Error kInternal if Draco fails. Thread safe.
GlbContent plainContent(const store::DecodedLod& lod, double step);

/// Returns the GLB of an LOD with images (textureLod()). Encodes all streams again, because atlases change
/// the texture coordinates, and glTF measures v from the top.
/// @param uri_of  returns the reference to a shared image, relative to the GLB.
/// @throws Error kInternal; as TextureLevels::part().
GlbContent texturedContent(const Mesh& mesh, const TextureSet& textures, double step, double error_model,
                           TextureLevels& levels, const std::function<std::string(SharedImage)>& uri_of);

}  // namespace lode::tiles
