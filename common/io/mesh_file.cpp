#include "common/io/mesh_file.h"

#include <string>

#include "common/error.h"
#include "common/io/glb_writer.h"
#include "common/io/obj_writer.h"
#include "common/io/output_target.h"
#include "common/io/ply_writer.h"

namespace lode {

MeshFormat meshFormatOf(const std::filesystem::path& path) {
  const std::string ending = fileEnding(path);
  if (ending == ".ply") return MeshFormat::kPly;
  if (ending == ".obj") return MeshFormat::kObj;
  if (ending == ".glb") return MeshFormat::kGlb;
  if (ending.empty() && (path.empty() || findOutput(path).is_stream || isStandardOutput(path)))
    return MeshFormat::kPly;
  throw Error(ErrorCode::kUsage, path.string() + ": PLY, OBJ and GLB can be written" +
                                     (ending.empty() ? "" : ", not " + ending) +
                                     ": give a name that ends in .ply, .obj or .glb");
}

void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const Lattice& lattice,
               const ImageFiles& images) {
  const MeshFormat format = meshFormatOf(path);
  if (mesh.attributes.bits != 0 && mesh.vertex_attributes.size() != mesh.positions.size())
    throw Error(ErrorCode::kInternal,
                path.string() + ": the mesh declares attributes but has none for some vertices");
  switch (format) {
    case MeshFormat::kPly:
      return writePly(path, mesh, lattice, images.set);
    case MeshFormat::kObj:
      return writeObj(path, mesh, lattice, images);
    case MeshFormat::kGlb:
      return writeGlb(path, mesh, lattice, images);
  }
}

}  // namespace lode
