#include "common/up_axis.h"

#include <array>

#include <gtest/gtest.h>

namespace lode {
namespace {

constexpr glm::dvec3 kY(0, 1, 0), kZ(0, 0, 1);

/// Quads in lattice steps.
class Faces {
 public:
  Faces& add(const std::array<glm::uvec3, 4>& corners) {
    const auto first = static_cast<uint32_t>(mesh_.positions.size());
    for (const glm::uvec3& corner : corners) mesh_.positions.push_back(packPosition(corner));
    mesh_.triangles.push_back({first, first + 1, first + 2});
    mesh_.triangles.push_back({first, first + 2, first + 3});
    return *this;
  }
  const Mesh& mesh() const { return mesh_; }

 private:
  Mesh mesh_;
};

/// Maps x, y, z to z, x, y, a number of times.
glm::uvec3 turned(glm::uvec3 p, int times) {
  for (int i = 0; i < times; ++i) p = {p.z, p.x, p.y};
  return p;
}

/// Terrain with z up before rotation: two slopes of a hill along x.
Mesh hill(int turns, bool reversed = false) {
  std::array<glm::uvec3, 4> rise{glm::uvec3{0, 0, 0}, {100, 0, 60}, {100, 100, 60}, {0, 100, 0}};
  std::array<glm::uvec3, 4> fall{glm::uvec3{100, 0, 60}, {200, 0, 0}, {200, 100, 0}, {100, 100, 60}};
  for (auto* face : {&rise, &fall}) {
    for (glm::uvec3& corner : *face) corner = turned(corner, turns);
    if (reversed) std::swap((*face)[1], (*face)[3]);
  }
  return Faces().add(rise).add(fall).mesh();
}

/// A closed wedge with a flat foot at z = 0 before rotation, and a ridge along x.
Mesh tent(int turns) {
  std::array<std::array<glm::uvec3, 4>, 5> faces{{
      {glm::uvec3{0, 0, 0}, {0, 100, 0}, {100, 100, 0}, {100, 0, 0}},
      {glm::uvec3{0, 0, 0}, {100, 0, 0}, {100, 50, 80}, {0, 50, 80}},
      {glm::uvec3{100, 100, 0}, {0, 100, 0}, {0, 50, 80}, {100, 50, 80}},
      {glm::uvec3{0, 0, 0}, {0, 50, 80}, {0, 50, 80}, {0, 100, 0}},
      {glm::uvec3{100, 0, 0}, {100, 100, 0}, {100, 50, 80}, {100, 50, 80}},
  }};
  Faces mesh;
  for (auto& face : faces) {
    for (glm::uvec3& corner : face) corner = turned(corner, turns);
    mesh.add(face);
  }
  return mesh.mesh();
}

TEST(UpAxis, isTheDirectionThatTheGroundFaces) {
  EXPECT_EQ(guessUp(hill(0)), kZ);
  EXPECT_EQ(guessUp(hill(2)), kY);
}

TEST(UpAxis, doesNotDependOnTheWindingOfGround) { EXPECT_EQ(guessUp(hill(0, true)), kZ); }

TEST(UpAxis, isOppositeToAFlatFoot) {
  EXPECT_EQ(guessUp(tent(0)), kZ);
  EXPECT_EQ(guessUp(tent(2)), kY);
}

TEST(UpAxis, isYByDefault) {
  EXPECT_EQ(guessUp(Mesh()), kY);
  EXPECT_EQ(guessUp(tent(1)), kY);  // a flat foot along x
}

TEST(UpAxis, isReadWithItsSign) {
  EXPECT_EQ(parseAxis("y"), kY);
  EXPECT_EQ(parseAxis("-z"), -kZ);
  for (const char* text : {"x", "y", "z", "-x", "-y", "-z"}) EXPECT_EQ(nameOfAxis(*parseAxis(text)), text);
  for (const char* text : {"", "-", "w", "xy", "+x", "--x", "Y"}) EXPECT_FALSE(parseAxis(text)) << text;
}

}  // namespace
}  // namespace lode
