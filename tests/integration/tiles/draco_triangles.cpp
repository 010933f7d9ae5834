// Decodes the Draco streams of GLB files as viewers do: draco_triangles STREAM...
// Writes for each file, as raw little-endian numbers: the number of vertices and of triangles (u32), the
// positions (3 x f32) and the triangles (3 x u32).
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

namespace {

template <typename T>
void put(const std::vector<T>& values) {
  std::fwrite(values.data(), sizeof(T), values.size(), stdout);
}

bool writeMesh(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), decoded.status().error_msg());
    return false;
  }
  const draco::Mesh& mesh = *decoded.value();
  put<uint32_t>({mesh.num_points(), mesh.num_faces()});
  std::vector<float> positions(size_t{3} * mesh.num_points());
  const auto* const attribute = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  for (uint32_t i = 0; i < mesh.num_points(); ++i)
    attribute->GetMappedValue(draco::PointIndex(i), &positions[size_t{3} * i]);
  put(positions);
  std::vector<uint32_t> corners;
  for (uint32_t i = 0; i < mesh.num_faces(); ++i)
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(i))) corners.push_back(corner.value());
  put(corners);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  bool is_good = true;
  for (int i = 1; i < argc; ++i) is_good = writeMesh(argv[i]) && is_good;
  return is_good ? 0 : 1;
}
