// Speed and quality of collapse() and cluster() beside meshoptimizer's simplifier.
//   bench_collapse [bunny.ply]      (an ascii file with x y z first; else
//   $LODESTREAM_TEST_DATA/a_bunny_zipper_ascii.ply)
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include <malloc.h>
#include <meshoptimizer.h>

#include "common/codec/octahedral.h"
#include "server/ingest/simplify/cluster.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/surface_distance.h"

namespace {

using lode::ingest::NodeMesh;
using lode::ingest::SimplifiedMesh;

double cpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct IndexedMesh {
  std::vector<glm::dvec3> points;
  std::vector<glm::u32vec3> triangles;
};

IndexedMesh readAscii(const std::string& path) {
  IndexedMesh mesh;
  std::ifstream file(path);
  std::string line, word;
  size_t vertices = 0, faces = 0;
  while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
    std::istringstream words(line);
    words >> word;
    if (word != "element") continue;
    words >> word;
    words >> (word == "vertex" ? vertices : faces);
  }
  mesh.points.resize(vertices);
  for (glm::dvec3& p : mesh.points) {
    std::getline(file, line);
    std::istringstream(line) >> p.x >> p.y >> p.z;
  }
  mesh.triangles.resize(faces);
  for (glm::u32vec3& t : mesh.triangles) {
    std::getline(file, line);
    std::istringstream(line) >> word >> t.x >> t.y >> t.z;
  }
  return mesh;
}

/// A bumpy sphere of 12 * n * n triangles.
IndexedMesh bumpySphere(uint32_t n) {
  IndexedMesh mesh;
  const uint32_t rows = 2 * n, columns = 3 * n;
  const auto place = [](double polar, double turn) {
    const glm::dvec3 p(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
    double height = 1, scale = 0.05;
    for (double f = 7; f < 200; f *= 2.3, scale *= 0.4)
      height += scale * std::sin(f * p.x) * std::sin(f * p.y + f) * std::sin(f * p.z + 1);
    return height * p;
  };
  for (uint32_t row = 1; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column)
      mesh.points.push_back(place(std::numbers::pi * row / rows, 2 * std::numbers::pi * column / columns));
  }
  const uint32_t north = (rows - 1) * columns, south = north + 1;
  mesh.points.push_back(place(0, 0));
  mesh.points.push_back(place(std::numbers::pi, 0));
  for (uint32_t column = 0; column < columns; ++column) {
    const uint32_t next = (column + 1) % columns;
    mesh.triangles.emplace_back(north, column, next);
    for (uint32_t row = 0; row + 2 < rows; ++row) {
      const uint32_t a = row * columns, b = a + columns;
      mesh.triangles.emplace_back(a + column, b + column, b + next);
      mesh.triangles.emplace_back(a + column, b + next, a + next);
    }
    mesh.triangles.emplace_back(south, (rows - 2) * columns + next, (rows - 2) * columns + column);
  }
  return mesh;
}

NodeMesh snap(const IndexedMesh& mesh, lode::Lattice& lattice, glm::uvec3& max_position) {
  std::vector<double> edges;
  glm::dvec3 min(std::numeric_limits<double>::max()), max(-min);
  for (const glm::u32vec3 t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      edges.push_back(glm::distance(mesh.points[t[k]], mesh.points[t[(k + 1) % 3]]));
      min = glm::min(min, mesh.points[t[k]]);
      max = glm::max(max, mesh.points[t[k]]);
    }
  }
  std::nth_element(edges.begin(), edges.begin() + static_cast<ptrdiff_t>(edges.size() / 20), edges.end());
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z});
  const double wanted = std::max(edges[edges.size() / 20] / 16, longest / ((1 << 21) - 2));
  lattice.step = std::exp2(std::floor(std::log2(wanted)));
  lattice.origin = glm::floor(min / lattice.step) * lattice.step;
  max_position = lattice.snap(max);
  NodeMesh node;
  std::unordered_map<uint64_t, uint32_t> known;
  std::vector<uint32_t> position(mesh.points.size());
  for (const glm::u32vec3 t : mesh.triangles) {
    glm::u32vec3 corners;
    for (int k = 0; k < 3; ++k) {
      const lode::PositionCode code = lode::packPosition(lattice.snap(mesh.points[t[k]]));
      const auto [i, added] = known.emplace(code.value, static_cast<uint32_t>(node.positions.size()));
      if (added) node.positions.push_back(code);
      corners[k] = i->second;
    }
    if (corners.x != corners.y && corners.y != corners.z && corners.z != corners.x)
      node.triangles.push_back(corners);
  }
  node.lca_depth.assign(node.positions.size(), lode::ingest::kNeverLocked);
  for (uint32_t i = 0; i < node.positions.size(); ++i) node.wedge_position.push_back(i);
  return node;
}

/// Gives a mesh one wedge a position, with normals and colours.
void addAttributes(NodeMesh& mesh, uint8_t bits) {
  mesh.attributes.bits = bits;
  std::vector<glm::dvec3> normals(mesh.positions.size());
  for (const glm::u32vec3 t : mesh.triangles) {
    const glm::dvec3 a(lode::unpackPosition(mesh.positions[t.x])),
        b(lode::unpackPosition(mesh.positions[t.y])), c(lode::unpackPosition(mesh.positions[t.z]));
    for (int k = 0; k < 3; ++k) normals[t[k]] += glm::cross(b - a, c - a);
  }
  mesh.wedge_attributes.resize(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec3 p(lode::unpackPosition(mesh.positions[i]));
    lode::VertexAttributes& attributes = mesh.wedge_attributes[i];
    if (bits & lode::AttributeSet::kNormal) attributes.normal = lode::encodeOctahedral(glm::vec3(normals[i]));
    if (bits & lode::AttributeSet::kColour)
      attributes.colour =
          glm::u8vec4(127 + 120 * std::sin(p.x * 0.01), 127 + 120 * std::sin(p.y * 0.01), 99, 255);
  }
}

lode::test::TriangleSoup soupOf(const NodeMesh& mesh, const lode::Lattice& lattice) {
  lode::test::TriangleSoup soup;
  const auto corner = [&](uint32_t wedge) {
    return lattice.toWorld(lode::unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
  };
  for (const glm::u32vec3 t : mesh.triangles) soup.push_back({corner(t.x), corner(t.y), corner(t.z)});
  return soup;
}

struct Flat {
  std::vector<float> points;
  std::vector<unsigned> indices;
};

Flat flatten(const IndexedMesh& mesh) {
  Flat flat;
  for (const glm::dvec3 p : mesh.points)
    for (int k = 0; k < 3; ++k) flat.points.push_back(static_cast<float>(p[k]));
  for (const glm::u32vec3 t : mesh.triangles) flat.indices.insert(flat.indices.end(), {t.x, t.y, t.z});
  return flat;
}

std::vector<unsigned> meshoptSimplify(const Flat& flat, size_t triangles) {
  std::vector<unsigned> result(flat.indices.size());
  float error = 0;
  result.resize(meshopt_simplify(result.data(), flat.indices.data(), flat.indices.size(), flat.points.data(),
                                 flat.points.size() / 3, 12, 3 * triangles, 1e9f, 0, &error));
  return result;
}

/// Medians of interleaved runs: a machine that others share changes its speed from one second to the next.
void speed(uint32_t n) {
  constexpr int kRuns = 15;
  using lode::AttributeSet;
  const IndexedMesh input = bumpySphere(n);
  lode::Lattice lattice;
  glm::uvec3 max_position;
  const NodeMesh plain = snap(input, lattice, max_position);
  NodeMesh painted = plain;
  addAttributes(painted, AttributeSet::kNormal | AttributeSet::kColour);
  const Flat flat = flatten(input);
  const size_t triangles = plain.triangles.size();
  const std::array<size_t, 1> target{triangles / 4};
  const lode::ingest::CollapseOptions options{0, max_position};
  std::array<std::vector<double>, 5> rates;
  const auto time = [&](size_t which, const auto& simplify, NodeMesh mesh) {
    const double start = cpuSeconds();
    simplify(std::move(mesh), target, options, [](size_t, SimplifiedMesh&&) {});
    rates[which].push_back(1e-6 * static_cast<double>(triangles) / (cpuSeconds() - start));
  };
  for (int run = 0; run < kRuns; ++run) {
    time(0, lode::ingest::collapse, plain);
    time(1, lode::ingest::collapse, painted);
    time(2, lode::ingest::cluster, plain);
    time(3, lode::ingest::cluster, painted);
    time(4, [&](auto&&...) { meshoptSimplify(flat, target[0]); }, {});
  }
  std::printf(
      "a sphere of %zu triangles to a quarter:\n\n"
      "| | million triangles a CPU second | of meshoptimizer 0.18, geometry |\n| --- | --- | --- |\n",
      triangles);
  const double theirs = median(rates[4]);
  constexpr std::array<const char*, 5> kNames{"collapse, geometry", "collapse, normals and colour",
                                              "cluster, geometry", "cluster, normals and colour",
                                              "meshoptimizer, geometry"};
  for (size_t i = 0; i < rates.size(); ++i)
    std::printf("| %s | %.2f | %.2f |\n", kNames[i], median(rates[i]), median(rates[i]) / theirs);
  std::printf("\n");
}

void quality(const std::string& path) {
  const IndexedMesh input = readAscii(path);
  if (input.triangles.empty()) {
    std::printf("no triangles in %s\n", path.c_str());
    return;
  }
  lode::Lattice lattice;
  glm::uvec3 max_position;
  const NodeMesh mesh = snap(input, lattice, max_position);
  lode::test::TriangleSoup original;
  for (const glm::u32vec3 t : input.triangles)
    original.push_back({input.points[t.x], input.points[t.y], input.points[t.z]});
  const double diagonal = lode::test::boxDiagonal(original);
  const std::array<size_t, 5> targets{34725, 18799, 6000, 1822, 642};
  const Flat flat = flatten(input);
  std::printf("bunny, lattice step %.2e of the diagonal\n", lattice.step / diagonal);
  std::printf("bunny, two-sided rms / max of the box diagonal (both, forward, backward rms):\n");
  const auto show = [&](const char* name, const lode::test::TriangleSoup& soup) {
    const auto d = lode::test::surfaceDistance(original, soup, 400000);
    std::printf("  %-14s %6zu triangles  %.3e / %.2e   (%.3e %.3e)\n", name, soup.size(),
                d.both.rms / diagonal, d.both.max / diagonal, d.forward.rms / diagonal,
                d.backward.rms / diagonal);
  };
  lode::ingest::cluster(mesh, targets, {0, max_position}, [&](size_t, SimplifiedMesh&& snapshot) {
    show("cluster", soupOf(snapshot.mesh, lattice));
  });
  lode::ingest::collapse(mesh, targets, {0, max_position}, [&](size_t target, SimplifiedMesh&& snapshot) {
    if (target == 0) show("lattice alone", soupOf(mesh, lattice));
    show("collapse", soupOf(snapshot.mesh, lattice));
    const std::vector<unsigned> indices = meshoptSimplify(flat, targets[target]);
    lode::test::TriangleSoup theirs;
    for (size_t i = 0; i < indices.size(); i += 3)
      theirs.push_back(
          {input.points[indices[i]], input.points[indices[i + 1]], input.points[indices[i + 2]]});
    show("meshoptimizer", theirs);
  });
}

}  // namespace

int main(int argc, char** argv) {
  // As in a build, whose larger blocks have raised glibc's thresholds by then: freed memory is kept.
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  speed(73);
  const char* folder = std::getenv("LODESTREAM_TEST_DATA");
  if (argc > 1) {
    quality(argv[1]);
  } else if (folder) {
    quality(std::string(folder) + "/a_bunny_zipper_ascii.ply");
  } else {
    std::printf("set LODESTREAM_TEST_DATA for the bunny\n");
  }
}
