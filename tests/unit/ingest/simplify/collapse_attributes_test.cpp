#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "common/codec/octahedral.h"
#include "server/ingest/simplify/collapse.h"
#include "tests/support/node_meshes.h"
#include "tests/support/surface_distance.h"

namespace lode::ingest {
namespace {

constexpr double kSheetSide = 4096;  // side of the sheet in lattice steps

double height(double x, double y) { return 150 * (1 + std::sin(0.004 * x + 1) * std::sin(0.003 * y)) + 20; }

/// Returns colours that vary smoothly over the sheet, except for a painted disc with a soft edge.
glm::dvec3 colourAt(double x, double y) {
  const double disc = 1 / (1 + std::exp((std::hypot(x - 1500, y - 2400) - 900) / 25));
  return {255 * disc, 127 + 60 * std::sin(0.002 * x), 127 + 60 * std::cos(0.0025 * y)};
}

/// Returns normals of a relief that is too fine for the mesh.
glm::dvec3 normalAt(double x, double y) {
  return glm::normalize(glm::dvec3(0.6 * std::tanh((x - 2000) / 40), 0.3 * std::sin(0.003 * y), 1));
}

Mesh paintedSheet(uint8_t bits) {
  test::MeshOptions options;
  options.bump = 0;
  Mesh sheet = test::makeGrid(100, 100, options);
  sheet.attributes.bits = bits;
  for (PositionCode& code : sheet.positions) {
    glm::uvec3 p = unpackPosition(code);
    p.z = static_cast<uint32_t>(height(p.x, p.y));
    code = packPosition(p);
    VertexAttributes attributes;
    if (bits & AttributeSet::kColour) attributes.colour = glm::u8vec4(glm::round(colourAt(p.x, p.y)), 255);
    if (bits & AttributeSet::kNormal) attributes.normal = encodeOctahedral(glm::vec3(normalAt(p.x, p.y)));
    if (bits & AttributeSet::kTexture)  // texture coordinates that are stretched in the middle
      attributes.texture = glm::u16vec2(30000 + 20000 * std::tanh((p.x - 2000.0) / 300), 10.0 * p.y);
    sheet.vertex_attributes.push_back(attributes);
  }
  return sheet;
}

struct Loss {
  double colour = 0;   ///< mean difference per channel, of 255
  double normal = 0;   ///< mean angle in radians
  double texture = 0;  ///< mean difference in steps of the texture grid
  double surface = 0;  ///< two-sided RMS distance in lattice steps
};

Loss lossOf(const Mesh& sheet, size_t triangles, double attribute_weight) {
  Loss loss;
  const CollapseOptions options{.max_position = test::boxOf(sheet).max, .attribute_weight = attribute_weight};
  collapse(test::nodeOf(sheet), std::array{triangles}, options, [&](size_t, SimplifiedMesh&& simplified) {
    const NodeMesh& mesh = simplified.mesh;
    double samples = 0;
    Mesh shape;
    for (const uint32_t position : mesh.wedge_position) shape.positions.push_back(mesh.positions[position]);
    shape.triangles = mesh.triangles;
    for (const glm::u32vec3 t : mesh.triangles) {
      const auto at = [&](int k) { return glm::dvec3(unpackPosition(shape.positions[t[k]])); };
      const double weight = glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
      for (int i = 0; i < 10; ++i) {
        for (int j = 0; i + j < 10; ++j) {
          const std::array<double, 3> share{(i + 0.33) / 10, (j + 0.33) / 10, 1 - (i + j + 0.66) / 10};
          glm::dvec3 p(0), colour(0), normal(0);
          glm::dvec2 texture(0);
          for (int k = 0; k < 3; ++k) {
            const VertexAttributes& attributes = mesh.wedge_attributes[t[k]];
            const double s = share[static_cast<size_t>(k)];
            p += s * at(k);
            colour += s * glm::dvec3(attributes.colour);
            normal += s * glm::dvec3(decodeOctahedral(attributes.normal));
            texture += s * glm::dvec2(attributes.texture);
          }
          const glm::dvec3 off = glm::abs(colour - colourAt(p.x, p.y));
          loss.colour += weight * (off.x + off.y + off.z) / 3;
          loss.normal +=
              weight * std::acos(std::min(glm::dot(glm::normalize(normal), normalAt(p.x, p.y)), 1.0));
          const glm::dvec2 moved =
              glm::abs(texture - glm::dvec2(30000 + 20000 * std::tanh((p.x - 2000) / 300), 10 * p.y));
          loss.texture += weight * (moved.x + moved.y) / 2;
          samples += weight;
        }
      }
    }
    loss.colour /= samples;
    loss.normal /= samples;
    loss.texture /= samples;
    loss.surface = test::surfaceDistance(test::latticeSoup(sheet), test::latticeSoup(shape), 20000).both.rms;
  });
  return loss;
}

TEST(CollapseAttributes, halvesTheColourErrorOfAPaintedSheet) {
  const Mesh sheet = paintedSheet(AttributeSet::kColour);
  const Loss with = lossOf(sheet, 1000, 1), without = lossOf(sheet, 1000, 0);
  EXPECT_LT(with.colour, 0.5 * without.colour);
  EXPECT_LT(with.surface, 1.25 * without.surface);
}

TEST(CollapseAttributes, halvesTheErrorOfNormalsThatDifferFromTheSurface) {
  const Mesh sheet = paintedSheet(AttributeSet::kNormal);
  const Loss with = lossOf(sheet, 1000, 1), without = lossOf(sheet, 1000, 0);
  EXPECT_LT(with.normal, 0.5 * without.normal);
  EXPECT_LT(with.surface, 1.25 * without.surface);
}

TEST(CollapseAttributes, halvesTheErrorOfAStretchedTexture) {
  const Mesh sheet = paintedSheet(AttributeSet::kTexture);
  const Loss with = lossOf(sheet, 1000, 1), without = lossOf(sheet, 1000, 0);
  EXPECT_LT(with.texture, 0.5 * without.texture);
  EXPECT_LT(with.surface, 1.25 * without.surface);
}

}  // namespace
}  // namespace lode::ingest
