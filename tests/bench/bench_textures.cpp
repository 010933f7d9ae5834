// What attribute quadrics save of a model's texture: bench_textures MODEL.ply...
// Simplifies each model, as one node, to a quarter, a tenth and a thirtieth of its triangles, with the
// texture in the quadrics and with geometry alone, and prints how far texture coordinates are off in the
// mean, as a fraction of the image, and the largest-fifth mean, with the surface's rms beside it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <random>
#include <vector>

#include "server/ingest/collapse.h"
#include "server/ingest/dereference.h"
#include "server/ingest/lattice_choice.h"
#include "server/ingest/leaf_mesh.h"
#include "tests/support/surface_distance.h"

namespace lode::test {
namespace {

constexpr size_t kSamples = 20000;
constexpr double kNear = 1e-3;  // of the diagonal: either side of a seam may be meant

struct TexturedTriangle {
  Triangle3 corners;
  std::array<glm::dvec2, 3> uv;
  uint16_t material = 0;
};

struct Model {
  ingest::NodeMesh mesh;
  glm::uvec3 extent{0};
  double uv_scale = 1;  ///< of the coordinates' grid, in images
};

Model readModel(const char* path) {
  const ingest::TemporaryFolder folder(std::filesystem::temp_directory_path());
  ingest::BuildOptions options;
  options.input = path;
  std::vector<std::string> warnings;
  const ingest::ScannedModel scanned = ingest::scan(options, folder, {}, warnings);
  const ingest::LatticeChoice choice = ingest::chooseLattice(scanned.input, path);
  AttributeSet attributes = scanned.input.attributes();
  std::vector<std::byte> records;
  ingest::dereference(scanned.input, choice.lattice, 1u << 30,
                      [&](const ingest::SoupTriangle& triangle) {
                        std::vector<std::byte> record(ingest::soupBytes(attributes));
                        ingest::storeSoup(triangle, record);
                        records.insert(records.end(), record.begin(), record.end());
                      },
                      {});
  ingest::MeshWelder welder;
  return {ingest::weldSoup(records, attributes, welder), choice.extent,
          std::ldexp(1.0, scanned.input.uvGrid().scale_exponent)};
}

std::vector<TexturedTriangle> trianglesOf(const ingest::NodeMesh& mesh, double uv_scale) {
  std::vector<TexturedTriangle> triangles;
  for (const glm::u32vec3& t : mesh.triangles) {
    const auto at = [&](int k) {
      return glm::dvec3(unpackPosition(mesh.positions[mesh.wedge_position[t[k]]]));
    };
    TexturedTriangle& triangle = triangles.emplace_back();
    triangle.corners = {at(0), at(1), at(2)};
    for (int k = 0; k < 3; ++k)
      triangle.uv[static_cast<size_t>(k)] =
          uv_scale * 0x1p-16 * glm::dvec2(mesh.wedge_attributes[t[k]].texture);
    triangle.material = mesh.wedge_attributes[t.x].material;
  }
  return triangles;
}

/// Shares of the corners in the point of a triangle that is nearest to p. Source: Ericson, Real-Time
/// Collision Detection, 2005, 5.1.5.
glm::dvec3 nearestShares(glm::dvec3 p, const Triangle3& t) {
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a, bp = p - t.b, cp = p - t.c;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
               d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / (d4 - d3 + (d5 - d6));
    return {0, 1 - w, w};
  }
  return glm::dvec3(va, vb, vc) / (va + vb + vc);
}

/// Distance in texture coordinates between a point of the original and what the simplified model shows there.
double textureError(glm::dvec3 p, glm::dvec2 uv, uint16_t material, double near,
                    const std::vector<TexturedTriangle>& simplified, std::vector<double>& distances,
                    std::vector<double>& errors) {
  distances.clear();
  errors.clear();
  double nearest = std::numeric_limits<double>::infinity();
  for (const TexturedTriangle& t : simplified) {
    if (t.material != material) continue;
    const glm::dvec3 s = nearestShares(p, t.corners);
    const double distance = glm::distance(p, s.x * t.corners.a + s.y * t.corners.b + s.z * t.corners.c);
    distances.push_back(distance);
    errors.push_back(glm::distance(uv, s.x * t.uv[0] + s.y * t.uv[1] + s.z * t.uv[2]));
    nearest = std::min(nearest, distance);
  }
  double error = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < errors.size(); ++i)
    if (distances[i] <= nearest + near) error = std::min(error, errors[i]);
  return error;
}

struct Loss {
  size_t triangles = 0;
  double mean = 0, worst_fifth = 0;  ///< in images
  double surface = 0;                ///< rms, of the diagonal
};

TriangleSoup shapeOf(const std::vector<TexturedTriangle>& triangles) {
  TriangleSoup soup;
  for (const TexturedTriangle& t : triangles) soup.push_back(t.corners);
  return soup;
}

Loss lossOf(const std::vector<TexturedTriangle>& original, const std::vector<TexturedTriangle>& simplified) {
  const TriangleSoup shape = shapeOf(original);
  const double diagonal = boxDiagonal(shape);
  std::vector<double> areas;
  for (const Triangle3& t : shape) areas.push_back(glm::length(glm::cross(t.b - t.a, t.c - t.a)));
  std::mt19937 random(1);
  std::discrete_distribution<size_t> choose(areas.begin(), areas.end());
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<double> all, distances, errors;
  for (size_t i = 0; i < kSamples; ++i) {
    const TexturedTriangle& t = original[choose(random)];
    const double r = std::sqrt(share(random)), s = share(random);
    const glm::dvec3 w(1 - r, r * (1 - s), r * s);
    const double error = textureError(w.x * t.corners.a + w.y * t.corners.b + w.z * t.corners.c,
                                      w.x * t.uv[0] + w.y * t.uv[1] + w.z * t.uv[2], t.material,
                                      kNear * diagonal, simplified, distances, errors);
    if (std::isfinite(error)) all.push_back(error);  // of a material that has vanished nothing can be said
  }
  std::sort(all.begin(), all.end(), std::greater<>());
  Loss loss;
  loss.triangles = simplified.size();
  for (size_t i = 0; i < all.size(); ++i) {
    loss.mean += all[i] / static_cast<double>(all.size());
    if (i < all.size() / 5) loss.worst_fifth += all[i] / static_cast<double>(all.size() / 5);
  }
  loss.surface = surfaceDistance(shape, shapeOf(simplified)).both.rms / diagonal;
  return loss;
}

std::vector<Loss> simplify(const Model& model, const std::vector<size_t>& targets, double weight) {
  const std::vector<TexturedTriangle> original = trianglesOf(model.mesh, model.uv_scale);
  std::vector<Loss> losses;
  const ingest::CollapseOptions options{.max_position = model.extent, .attribute_weight = weight};
  ingest::collapse(model.mesh, targets, options, [&](size_t, ingest::SimplifiedMesh&& simplified) {
    losses.push_back(lossOf(original, trianglesOf(simplified.mesh, model.uv_scale)));
  });
  return losses;
}

void measure(const char* path) {
  const Model model = readModel(path);
  if (!model.mesh.attributes.has(AttributeSet::kTexture)) throw std::runtime_error("no texture coordinates");
  const size_t triangles = model.mesh.triangles.size();
  const std::vector<size_t> targets{triangles / 4, triangles / 10, triangles / 30};
  const std::vector<Loss> with = simplify(model, targets, 1), without = simplify(model, targets, 0);
  std::printf("%s, %zu triangles\n", path, triangles);
  for (size_t i = 0; i < std::min(with.size(), without.size()); ++i)
    std::printf(
        "  %6zu / %6zu triangles  texture with %.5f, without %.5f of the image (x %.2f; worst fifth x %.2f)  "
        "surface with %.2e, without %.2e of the diagonal\n",
        with[i].triangles, without[i].triangles, with[i].mean, without[i].mean,
        without[i].mean / with[i].mean, without[i].worst_fifth / with[i].worst_fifth, with[i].surface,
        without[i].surface);
}

}  // namespace
}  // namespace lode::test

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: bench_textures MODEL.ply...\n");
    return 2;
  }
  try {
    for (int i = 1; i < count; ++i) lode::test::measure(arguments[i]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_textures: %s\n", error.what());
    return 1;
  }
}
