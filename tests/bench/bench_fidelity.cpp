// How far cuts of a model are from the original: bench_fidelity ORIGINAL.ply CUT.ply...
// Prints the two-sided sampled distances of each cut as fractions of the original's box diagonal and, for
// cuts of the bunny, the reference of meshoptimizer 1.2 on the whole mesh, interpolated in log-log at the
// cut's triangle count.

#include <cmath>
#include <cstdio>
#include <exception>
#include <span>
#include <string_view>
#include <vector>

#include "server/ingest/ply_reader.h"
#include "server/ingest/triangulate.h"
#include "tests/support/surface_distance.h"

namespace lode::test {
namespace {

constexpr size_t kSamples = 1000000;  // each way

struct Reference {
  double triangles, rms;
};
constexpr Reference kBunny[] = {{642, 2.30e-3}, {1822, 9.16e-4}, {18799, 1.13e-4}};

double bunnyReference(double triangles) {
  const Reference* from = triangles < kBunny[1].triangles ? &kBunny[0] : &kBunny[1];
  const double slope = std::log(from[1].rms / from[0].rms) / std::log(from[1].triangles / from[0].triangles);
  return from[0].rms * std::pow(triangles / from[0].triangles, slope);
}

TriangleSoup readSoup(const char* path) {
  ingest::PlyReader reader(path, {});
  std::vector<glm::dvec3> positions, outline;
  std::vector<glm::u32vec3> cut;
  TriangleSoup soup;
  reader.read(
      [&](uint64_t, std::span<const ingest::PlyVertex> vertices) {
        for (const auto& vertex : vertices) positions.push_back(vertex.position);
      },
      [&](const ingest::PlyFaces& faces) {
        size_t first = 0;
        for (const uint32_t corners : faces.corner_counts) {
          outline.clear();
          for (uint32_t c = 0; c < corners; ++c) outline.push_back(positions[faces.corners[first + c]]);
          ingest::triangulate(outline, cut);
          for (const glm::u32vec3& t : cut) soup.push_back({outline[t.x], outline[t.y], outline[t.z]});
          first += corners;
        }
      });
  return soup;
}

void measure(const TriangleSoup& original, const char* path, bool is_bunny) {
  const TriangleSoup cut = readSoup(path);
  const double diagonal = boxDiagonal(original);
  const SurfaceDistance distance = surfaceDistance(original, cut, kSamples);
  std::printf("%9zu triangles  rms %.3e  largest %.3e of the diagonal", cut.size(),
              distance.both.rms / diagonal, distance.both.max / diagonal);
  if (is_bunny) {
    const double reference = bunnyReference(static_cast<double>(cut.size()));
    std::printf("  reference %.3e  ours / reference %.3f", reference,
                distance.both.rms / diagonal / reference);
  }
  std::printf("  %s\n", path);
}

}  // namespace
}  // namespace lode::test

int main(int count, char** arguments) {
  if (count < 3) {
    std::fprintf(stderr, "usage: bench_fidelity ORIGINAL.ply CUT.ply...\n");
    return 2;
  }
  try {
    const auto original = lode::test::readSoup(arguments[1]);
    const bool is_bunny = std::string_view(arguments[1]).find("bun") != std::string_view::npos;
    for (int i = 2; i < count; ++i) lode::test::measure(original, arguments[i], is_bunny);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_fidelity: %s\n", error.what());
    return 1;
  }
}
