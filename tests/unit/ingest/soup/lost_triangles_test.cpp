#include "server/ingest/soup/lost_triangles.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

uint64_t lostOf(std::vector<glm::dvec3> corners) { return LostTriangleCounter(Lattice{}).count(corners); }

TEST(LostTriangles, haveCornersThatTheLatticeMerges) {
  EXPECT_EQ(lostOf({{0, 0, 0}, {0.3, 0, 0}, {5, 0, 0}}), 1u);
  EXPECT_EQ(lostOf({{0, 0, 0}, {1, 0, 0}, {5, 0, 0}}), 0u);
  EXPECT_EQ(lostOf({{0, 0, 0}, {0, 0, 0}, {5, 0, 0}}), 0u) << "flat in the file";
}

TEST(LostTriangles, areCountedForTheTrianglesOfAPolygon) {
  EXPECT_EQ(lostOf({{0, 0, 0}, {5, 0, 0}, {5, 5, 0}, {0, 5, 0}}), 0u);
  EXPECT_EQ(lostOf({{0, 0, 0}, {0.3, 0, 0}, {5, 5, 0}, {0, 5, 0}}), 1u);
  EXPECT_EQ(lostOf({{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}}), 2u);
}

TEST(LostTriangles, areMostWhereFewerAreLeft) {
  EXPECT_FALSE((LostTriangles{.lost = 5, .of = 10}).areMost());
  EXPECT_TRUE((LostTriangles{.lost = 6, .of = 10}).areMost());
}

TEST(LostTriangles, nameTheBoxWhereTheyAreMost) {
  LostTriangles lost{.lost = 1, .of = 10, .step = 4, .min = {0, 0, 0}, .max = {500005, 5.3e6, 120}};
  EXPECT_EQ(lost.inWords().find("1 triangle with corners less than 4 apart"), 14u) << lost.inWords();
  EXPECT_EQ(lost.inWords().find("500005"), std::string::npos);
  lost.lost = 9;
  EXPECT_EQ(
      lost.inWords(),
      "9 of 10 triangles would be lost: their corners are closer than a 2-millionth of the model, which "
      "extends from [0, 0, 0] to [500005, 5.3e+06, 120]; remove distant stray vertices, or split the model");
}

}  // namespace
}  // namespace lode::ingest
