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

std::vector<std::filesystem::path> writeMesh(const std::filesystem::path& path, const Mesh& mesh,
                                             const Lattice& lattice, const ImageFiles& images) {
  const MeshFormat format = meshFormatOf(path);
  if (mesh.attributes.bits != 0 && mesh.vertex_attributes.size() != mesh.positions.size())
    throw Error(ErrorCode::kInternal,
                path.string() + ": some vertices lack attributes that the mesh declares");
  std::vector<std::filesystem::path> beside = images.written;
  if (format == MeshFormat::kPly) writePly(path, mesh, lattice, images.set);
  if (format == MeshFormat::kGlb) writeGlb(path, mesh, lattice, images);
  if (format == MeshFormat::kObj && writeObj(path, mesh, lattice, images))
    beside.push_back(materialFileOf(path));
  return beside;
}

std::string describeFilesBeside(const std::vector<std::filesystem::path>& files) {
  std::string text;
  for (const std::filesystem::path& file : files)
    text += (text.empty() ? "written beside it: " : ", ") + file.string();
  return text.empty() ? text : text + "\n";
}

}  // namespace lode
