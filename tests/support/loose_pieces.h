#pragma once

#include <cstdint>
#include <random>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "tests/support/test_meshes.h"

/// Meshes like scans with many loose pieces, made from a seed.
namespace lode::test {

struct LoosePieces {
  uint32_t pieces = 200;
  uint32_t largest = 100;         ///< largest number of triangles of a piece; most pieces are small
  double edge = 40;               ///< length of an edge in lattice steps
  uint32_t extent = kMaxLattice;  ///< side of the box in which the pieces are scattered
  uint32_t seed = 1;
};

/// Adds strips of triangles to a mesh without attributes. The strips are far apart, but every fourth strip
/// shares one vertex with the previous strip.
inline void addLoosePieces(Mesh& mesh, const LoosePieces& options) {
  std::mt19937 random(options.seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  const auto direction = [&] {
    glm::dvec3 d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    while (glm::length(d) < 0.1) d = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    return glm::normalize(d);
  };
  const auto add = [&](glm::dvec3 at) {
    const glm::dvec3 inside = glm::clamp(glm::round(at), 0.0, double(options.extent));
    mesh.positions.push_back(packPosition(glm::uvec3(inside)));
    return static_cast<uint32_t>(mesh.positions.size() - 1);
  };
  const double reach = options.extent - 1.0;
  for (uint32_t piece = 0; piece < options.pieces; ++piece) {
    const double share = uniform(0, 1);
    const auto triangles = 1 + static_cast<uint32_t>(share * share * share * options.largest);
    const glm::dvec3 along = direction(), across = glm::normalize(glm::cross(along, direction()));
    const bool touches = piece % 4 == 3;
    glm::dvec3 at(uniform(0, reach), uniform(0, reach), uniform(0, reach));
    if (touches) at = glm::dvec3(unpackPosition(mesh.positions.back()));
    uint32_t a = touches ? static_cast<uint32_t>(mesh.positions.size() - 1) : add(at);
    uint32_t b = add(at + options.edge * across);
    for (uint32_t t = 0; t < triangles; ++t) {
      at += options.edge * uniform(0.4, 0.7) * along;
      const uint32_t c = add(at + options.edge * (t % 2 == 0 ? 0.0 : 1.0) * across);
      mesh.triangles.push_back(t % 2 == 0 ? glm::u32vec3(a, b, c) : glm::u32vec3(b, a, c));
      a = b;
      b = c;
    }
  }
}

/// Makes a bumpy sphere among loose pieces, which are far from the sphere and from each other.
inline Mesh makeScanWithLoosePieces(uint32_t slices, uint32_t stacks, const LoosePieces& pieces) {
  MeshOptions sphere;
  sphere.extent = pieces.extent / 16;
  sphere.origin = glm::uvec3(pieces.extent / 2);
  sphere.seed = pieces.seed;
  Mesh mesh = makeSphere(slices, stacks, sphere);
  addLoosePieces(mesh, pieces);
  return mesh;
}

}  // namespace lode::test
