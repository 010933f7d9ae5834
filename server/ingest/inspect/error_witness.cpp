#include "server/ingest/inspect/error_witness.h"

#include <cstdio>
#include <limits>
#include <span>

#include "common/nearest_point.h"
#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/open_edges.h"

namespace lode::ingest {
namespace {

/// Keeps the point nearest to `from` among the points, triangles and edges added.
class NearestPoint {
 public:
  explicit NearestPoint(glm::dvec3 from) : from_(from) {}

  void add(glm::dvec3 point) {
    const double steps = glm::distance(from_, point);
    if (!(steps < steps_)) return;
    steps_ = steps;
    at_ = point;
  }
  void addTriangles(const Mesh& mesh) {
    const auto cornerOf = [&](uint32_t vertex) { return glm::dvec3(unpackPosition(mesh.positions[vertex])); };
    for (const glm::u32vec3& t : mesh.triangles)
      add(nearestPointOfTriangle(from_, {cornerOf(t.x), cornerOf(t.y), cornerOf(t.z)}));
  }
  void addEdges(std::span<const store::OpenEdge> edges) {
    for (const store::OpenEdge& edge : edges)
      add(nearestPointOfSegment(from_, glm::dvec3(unpackPosition(edge.a)),
                                glm::dvec3(unpackPosition(edge.b))));
  }

  double steps() const { return steps_; }
  glm::dvec3 at() const { return at_; }

 private:
  const glm::dvec3 from_;
  double steps_ = std::numeric_limits<double>::infinity();
  glm::dvec3 at_{0};
};

/// Adds to `nearest` all triangles of the leaves below a node, or only the boundary edges of these leaves.
void addLeaves(const store::Reader& reader, NodeKey above, bool only_boundaries, NearestPoint& nearest) {
  store::OpenEdges boundaries;
  for (const Node& node : reader.nodes()) {
    if (!node.isLeaf() || !above.contains(node.key)) continue;
    const Mesh leaf = store::readLod(reader, node, 0);
    if (only_boundaries)
      boundaries.add(leaf);
    else
      nearest.addTriangles(leaf);
  }
  nearest.addEdges(boundaries.edges());
}

std::string describe(glm::dvec3 point) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.12g %.12g %.12g)", point.x, point.y, point.z);
  return text;
}

std::string describe(double length) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", length);
  return text;
}

}  // namespace

ErrorWitness witnessOf(const store::Reader& reader, const LodAt& lod, const MeasuredError& measured) {
  const FarPoint& found = measured.found;
  NearestPoint nearest(found.at);
  if (found.of_lod)
    addLeaves(reader, lod.node->key, found.on_boundary, nearest);
  else
    nearest.addTriangles(store::readLod(reader, *lod.node, lod.lod));
  const Lattice& lattice = reader.summary().lattice;
  const auto trueOf = [&](glm::dvec3 steps) { return lattice.origin + lattice.step * steps; };
  return {.node = lod.node->key,
          .lod = lod.lod,
          .stored_error = measured.stored_steps * lattice.step,
          .distance = nearest.steps() * lattice.step,
          .point = trueOf(found.at),
          .nearest = trueOf(nearest.at()),
          .of_lod = found.of_lod,
          .on_boundary = found.on_boundary};
}

std::string describe(const ErrorWitness& witness) {
  const std::string part = witness.on_boundary ? "the boundary of " : "";
  const std::string lod = part + "the LOD", input = part + "the input";
  return "node " + store::describeKey(witness.node) + ", LOD " + std::to_string(witness.lod) +
         ": its stored error is " + describe(witness.stored_error) + ", but the point " +
         describe(witness.point) + " of " + (witness.of_lod ? lod : input) + " is " +
         describe(witness.distance) + " from the nearest point " + describe(witness.nearest) + " of " +
         (witness.of_lod ? input : lod);
}

}  // namespace lode::ingest
