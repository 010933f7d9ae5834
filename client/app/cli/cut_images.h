#pragma once

#include <filesystem>
#include <vector>

#include "client/core/lod/cut.h"
#include "common/io/mesh_materials.h"
#include "common/mesh.h"

namespace lode::app {

/// The textures of a mesh, with the names of their files.
struct CutImages {
  ImageFiles files;                   ///< a texture without a file has no image
  std::vector<std::string> left_out;  ///< names of textures that the mesh wears and of which nothing is there
};

/// Writes the images that a cut's mesh wears as PNG files beside the mesh's file, as sharp as they are
/// resident: see ResidentImage and ImageNames. @throws Error kIo; kUsage for a pipe or a device.
CutImages writeCutImages(const core::Cut& cut, const Mesh& mesh, const std::filesystem::path& mesh_file);

}  // namespace lode::app
