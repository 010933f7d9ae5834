#include "server/ingest/inspect/topology.h"

#include <array>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "common/groups.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/lattice_choice.h"

namespace lode::ingest {
namespace {

struct Model {
  std::vector<PlyVertex> vertices;
  PlyFaces faces;
};

/// Faces with three to five corners at few positions, many of which have several vertices.
Model randomModel(uint32_t seed, uint32_t vertices, uint32_t faces) {
  std::mt19937 engine(seed);
  const auto random = [&] { return static_cast<uint32_t>(engine()); };
  Model model;
  for (uint32_t i = 0; i < vertices; ++i) {
    PlyVertex vertex;
    const uint32_t place = random() % (vertices / 2);
    vertex.position = {place % 97, place / 97, place % 5};
    vertex.normal = {0, 0, random() % 2 == 0 ? 1.f : -1.f};
    model.vertices.push_back(vertex);
  }
  for (uint32_t i = 0; i < faces; ++i) {
    const uint32_t corners = 3 + random() % 3, near = random() % vertices;
    model.faces.corner_counts.push_back(corners);
    for (uint32_t c = 0; c < corners; ++c) model.faces.corners.push_back((near + random() % 9) % vertices);
  }
  return model;
}

Topology countedWith(const Model& model, uint64_t memory_bytes) {
  const TemporaryFolder folder(::testing::TempDir());
  AttributeSet attributes;
  attributes.bits = AttributeSet::kNormal;
  TopologyCounter counter(folder, attributes, false, memory_bytes);
  counter.addVertices(model.vertices);
  counter.addFaces(model.faces);
  return counter.count();
}

/// Counts edges, duplicates and pieces with maps.
Topology countedByMaps(const Model& model) {
  Topology topology;
  std::map<std::array<double, 3>, uint32_t> first_at;
  std::vector<uint32_t> first;
  for (const PlyVertex& vertex : model.vertices) {
    const glm::dvec3 p = vertex.position;
    const auto number = static_cast<uint32_t>(first.size());
    first.push_back(first_at.emplace(std::array{p.x, p.y, p.z}, number).first->second);
    topology.duplicate_vertices += first.back() != number;
  }
  Groups groups(model.vertices.size());
  std::set<uint64_t> used, used_places;
  std::map<std::pair<uint32_t, uint32_t>, std::vector<bool>> uses;
  size_t begin = 0;
  for (const uint32_t corners : model.faces.corner_counts) {
    std::vector<uint32_t> face;
    for (size_t c = begin; c < begin + corners; ++c) {
      used.insert(model.faces.corners[c]);
      face.push_back(first[model.faces.corners[c]]);
      topology.pieces += used_places.insert(face.back()).second;
      topology.pieces -= groups.join(face.front(), face.back());
    }
    begin += corners;
    std::vector<std::pair<uint32_t, uint32_t>> sides;
    for (size_t c = 0; c < corners; ++c)
      if (face[c] != face[(c + 1) % corners]) sides.emplace_back(face[c], face[(c + 1) % corners]);
    topology.flat_faces += sides.size() < 3;
    if (sides.size() < 3) continue;
    for (const auto& [from, to] : sides) uses[std::minmax(from, to)].push_back(from < to);
  }
  topology.unused_vertices = model.vertices.size() - used.size();
  for (const auto& [edge, directions] : uses) {
    topology.open_edges += directions.size() == 1;
    topology.non_manifold_edges += directions.size() > 2;
    topology.misoriented_edges += directions.size() == 2 && directions[0] == directions[1];
  }
  return topology;
}

TEST(Topology, agreesWithMapsInLittleMemory) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    const Model model = randomModel(seed, 30000, 8000 * seed);
    const Topology maps = countedByMaps(model), counted = countedWith(model, 64 << 10);
    EXPECT_EQ(counted.duplicate_vertices, maps.duplicate_vertices) << seed;
    EXPECT_EQ(counted.unused_vertices, maps.unused_vertices) << seed;
    EXPECT_EQ(counted.flat_faces, maps.flat_faces) << seed;
    EXPECT_EQ(counted.open_edges, maps.open_edges) << seed;
    EXPECT_EQ(counted.non_manifold_edges, maps.non_manifold_edges) << seed;
    EXPECT_EQ(counted.misoriented_edges, maps.misoriented_edges) << seed;
    EXPECT_EQ(counted.pieces, maps.pieces) << seed;
  }
}

TEST(Topology, doesNotDependOnMemory) {
  const Model model = randomModel(7, 30000, 20000);
  const Topology little = countedWith(model, 64 << 10), much = countedWith(model, 64 << 20);
  EXPECT_EQ(little.pieces, much.pieces);
  EXPECT_EQ(little.open_edges, much.open_edges);
  EXPECT_EQ(little.opposed_faces, much.opposed_faces);
  EXPECT_EQ(little.lost_triangles, much.lost_triangles);
  EXPECT_EQ(little.lattice_step, much.lattice_step);
}

TEST(Topology, countsAsManyLostTrianglesAsABuildDrops) {
  std::mt19937 random(11);
  Model model;
  for (uint64_t face = 0; face < 500; ++face) {
    const auto corners = static_cast<uint32_t>(3 + random() % 4);
    model.faces.corner_counts.push_back(corners);
    for (uint32_t c = 0; c < corners; ++c) {
      model.faces.corners.push_back(model.vertices.size());
      // Makes some corners of a face neighbours on a lattice of thousands of steps.
      model.vertices.push_back(
          {.position = {static_cast<double>(random() % 3) + 1e-9 * c, face % 50, face % 7}});
    }
  }
  const TemporaryFolder folder(::testing::TempDir());
  PackedInput input(folder, {}, true);
  input.addVertices(model.vertices);
  input.addFaces(model.faces);
  input.flush();
  const Lattice lattice = chooseLattice(input, "a.ply").lattice;
  const DereferenceCounts counts =
      dereference({.input = input, .lattice = lattice, .memory_bytes = 1 << 20}, [](auto) {});
  TopologyCounter counter(folder, {}, true, 1 << 20);
  counter.addVertices(model.vertices);
  counter.addFaces(model.faces);
  const Topology topology = counter.count();
  EXPECT_EQ(topology.lost_triangles, counts.lost);
  EXPECT_EQ(topology.lattice_step, lattice.step);
  EXPECT_GT(counts.lost, 100u);
  EXPECT_LT(counts.lost, counts.triangles + counts.dropped);
}

}  // namespace
}  // namespace lode::ingest
