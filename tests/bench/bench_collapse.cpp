// Compares the speed of collapse(), cluster() and meshoptimizer's simplifier, which reduce a sphere to a
// quarter of its triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <unordered_map>
#include <vector>

#include <malloc.h>
#include <meshoptimizer.h>

#include "common/codec/octahedral.h"
#include "server/ingest/simplify/cluster.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/bench/print_row.h"

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

/// Makes a bumpy sphere of 12 * n * n triangles.
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

/// Gives a mesh one wedge per position, with normals and colours.
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

/// Measures medians of interleaved runs, since a shared machine changes its speed within seconds.
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
  const double theirs = median(rates[4]);
  constexpr std::array<const char*, 5> kNames{"collapse, geometry", "collapse, normals and colour",
                                              "cluster, geometry", "cluster, normals and colour",
                                              "meshoptimizer, geometry"};
  for (size_t i = 0; i < rates.size(); ++i)
    lode::bench::printRow({{"simplifier", kNames[i]},
                           {"million_triangles_a_cpu_s", median(rates[i])},
                           {"of_meshoptimizer", median(rates[i]) / theirs}});
}

}  // namespace

int main() {
  // Keep freed memory, as in a build: its larger blocks have raised glibc's thresholds.
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  speed(73);
}
