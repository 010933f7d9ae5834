// Reads any bytes as a PLY file: header and body, in all encodings, with and without skip_bad. The faces and
// vertices that the reader returns must satisfy ply_reader.h. Polygons are cut into triangles as in a build.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/soup/triangulate.h"
#include "tests/support/memory_file.h"

namespace {

using namespace lode::ingest;

void require(bool condition) {
  if (!condition) std::abort();
}

void checkFaces(const PlyFaces& faces, const std::vector<glm::dvec3>& positions) {
  std::vector<glm::dvec3> polygon;
  std::vector<glm::u32vec3> triangles;
  size_t first = 0;
  for (const uint32_t count : faces.corner_counts) {
    require(count >= 3 && first + count <= faces.corners.size());
    polygon.clear();
    for (size_t i = first; i < first + count; ++i) {
      require(faces.corners[i] < positions.size());
      polygon.push_back(positions[faces.corners[i]]);
    }
    triangulate(polygon, triangles);
    require(triangles.size() == count - 2);
    first += count;
  }
  require(first == faces.corners.size());
  require(faces.texture.empty() || faces.texture.size() == faces.corners.size());
  require(faces.materials.empty() || faces.materials.size() == faces.corner_counts.size());
}

void readAll(const std::filesystem::path& path, bool skip_bad) {
  try {
    PlyReader reader(path, {.skip_bad = skip_bad});
    std::vector<glm::dvec3> positions;
    const PlyCounts counts = reader.read(
        [&](uint64_t at, std::span<const PlyVertex> rows) {
          require(at == positions.size() && !rows.empty());
          for (const PlyVertex& row : rows) {
            require(glm::all(glm::lessThan(glm::abs(row.position), glm::dvec3(HUGE_VAL))));
            positions.push_back(row.position);
          }
        },
        [&](const PlyFaces& faces) { checkFaces(faces, positions); });
    require(counts.vertices == positions.size());
    require(skip_bad || counts.skipped_bad + counts.replaced_attributes == 0);
  } catch (const lode::Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const lode::test::MemoryFile file(std::string_view(reinterpret_cast<const char*>(data), size));
  readAll(file.path(), false);
  readAll(file.path(), true);
  return 0;
}
