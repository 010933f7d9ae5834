#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/inspect/against.h"
#include "server/ingest/pipeline/build.h"
#include "server/store/reader.h"
#include "tests/support/surface_distance.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/inspect/altered_store.h"

namespace lode::ingest {
namespace {

/// A mesh in double precision, for shapes that need it.
class Shape {
 public:
  using Path = glm::dvec3 (*)(double share);

  void addTriangle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const auto first = static_cast<uint32_t>(vertices_.size());
    vertices_.insert(vertices_.end(), {a, b, c});
    triangles_.emplace_back(first, first + 1, first + 2);
  }

  /// Adds a grid of columns × rows cells. @param at  maps shares of columns and rows to a point.
  template <typename At>
  void addGrid(uint32_t columns, uint32_t rows, const At& at) {
    const auto first = static_cast<uint32_t>(vertices_.size());
    for (uint32_t y = 0; y <= rows; ++y)
      for (uint32_t x = 0; x <= columns; ++x)
        vertices_.push_back(at(static_cast<double>(x) / columns, static_cast<double>(y) / rows));
    for (uint32_t y = 0; y < rows; ++y) {
      for (uint32_t x = 0; x < columns; ++x) {
        const uint32_t a = first + y * (columns + 1) + x, b = a + columns + 1;
        triangles_.emplace_back(a, a + 1, b);
        triangles_.emplace_back(a + 1, b + 1, b);
      }
    }
  }

  /// Adds a tube without ends.
  void addTube(Path path, double radius, uint32_t rings, uint32_t sides) {
    addGrid(sides, rings, [&](double around, double along) {
      const glm::dvec3 ahead = glm::normalize(path(along + 1e-4) - path(along - 1e-4));
      const glm::dvec3 other = std::abs(ahead.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
      const glm::dvec3 right = glm::normalize(glm::cross(ahead, other)), up = glm::cross(right, ahead);
      const double angle = 2 * std::numbers::pi * around;
      return path(along) + radius * (std::cos(angle) * right + std::sin(angle) * up);
    });
  }

  void addSphere(glm::dvec3 middle, glm::dvec3 radius, uint32_t columns, uint32_t rows) {
    addGrid(columns, rows, [&](double u, double v) {
      const double around = 2 * std::numbers::pi * u, down = std::numbers::pi * v;
      const double bump = 1 + 0.08 * std::sin(5 * around) * std::sin(7 * down);
      return middle + radius * bump *
                          glm::dvec3(std::sin(down) * std::cos(around), std::sin(down) * std::sin(around),
                                     std::cos(down));
    });
  }

  void write(const std::filesystem::path& file) const {
    std::ofstream out(file);
    out.precision(12);
    out << "ply\nformat ascii 1.0\nelement vertex " << vertices_.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << triangles_.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const glm::dvec3 v : vertices_) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (const glm::u32vec3 t : triangles_) out << "3 " << t.x << ' ' << t.y << ' ' << t.z << '\n';
  }

 private:
  std::vector<glm::dvec3> vertices_;
  std::vector<glm::u32vec3> triangles_;
};

double noise(double x, double y) {
  return std::sin(13 * x + 3 * y) * std::cos(17 * y - 5 * x) + 0.3 * std::sin(41 * x) * std::sin(37 * y + x);
}

Shape pipeline() {
  Shape shape;
  shape.addTube([](double t) { return glm::dvec3(2000 * t, 20 * std::sin(9 * t), 0); }, 0.15, 200, 8);
  return shape;
}

Shape pipeAlongADiagonal() {
  Shape shape;
  shape.addTube([](double t) { return t * glm::dvec3(900, 1100, 700); }, 0.2, 220, 6);
  return shape;
}

Shape spring() {
  Shape shape;
  shape.addTube([](double t) { return glm::dvec3(40 * std::cos(60 * t), 40 * std::sin(60 * t), 300 * t); },
                0.05, 300, 6);
  return shape;
}

Shape needles() {
  Shape shape;
  std::mt19937_64 random(7);
  const auto roll = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
  for (int i = 0; i < 250; ++i) {
    const glm::dvec3 foot(50 * roll(), 50 * roll(), 50 * roll());
    const glm::dvec3 tip = foot + 900.0 * glm::dvec3(roll(), roll(), roll());
    const glm::dvec3 a = foot + glm::dvec3(0.05, 0, 0), b = foot + glm::dvec3(0, 0.05, 0),
                     c = foot + glm::dvec3(0, 0, 0.05);
    shape.addTriangle(a, b, tip);
    shape.addTriangle(b, c, tip);
    shape.addTriangle(c, a, tip);
  }
  return shape;
}

Shape kilometresAndMetres() {
  Shape shape;
  shape.addGrid(40, 40, [](double x, double y) { return glm::dvec3(0.012 * x, 0.012 * y, noise(x, y)); });
  return shape;
}

Shape flatTerrain() {
  Shape shape;
  shape.addGrid(45, 45, [](double x, double y) { return glm::dvec3(12e3 * x, 12e3 * y, 40 * noise(x, y)); });
  return shape;
}

Shape farApart() {
  Shape shape;
  shape.addSphere({0, 0, 0}, glm::dvec3(1), 30, 20);
  shape.addSphere({4e3, 1e3, -2e3}, glm::dvec3(1), 30, 20);
  return shape;
}

Shape farFromTheOrigin() {
  Shape shape;
  shape.addSphere({5e6, -3e6, 4e5}, glm::dvec3(2), 40, 30);
  return shape;
}

Shape comb() {
  Shape shape;
  for (int i = 0; i < 60; ++i)
    shape.addGrid(6, 3, [i](double x, double y) {
      return glm::dvec3(400 * x, 0.3 * i + 0.02 * y, 0.3 * std::sin(40 * x + i) + 0.004 * y * y);
    });
  return shape;
}

Shape stretchedSphere() {
  Shape shape;
  shape.addSphere({0, 0, 0}, {1, 1, 3000}, 30, 40);
  return shape;
}

AgainstReport buildAndCompare(const std::filesystem::path& input, const std::filesystem::path& store,
                              uint32_t triangles_per_node) {
  BuildOptions options;
  options.input = input;
  options.output = store;
  options.triangles_per_node = triangles_per_node;
  build(options);
  AgainstOptions against;
  against.store = store;
  against.input = input;
  return compareWithInput(against);
}

TEST(SoundStoreOfAFile, isCalledSound) {
  const char* const data = std::getenv("LODESTREAM_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with real scans";
  const std::filesystem::path wild = std::filesystem::path(data) / "wild";
  if (!std::filesystem::exists(wild)) GTEST_SKIP() << wild << " does not exist";
  const test::WorkFolder folder;
  EXPECT_GE(buildAndCompare(wild / "km_and_m_heights.ply", folder / "heights.lode", 512).least_ratio, 1);
  EXPECT_GE(buildAndCompare(wild / "pipeline_2km_r015.ply", folder / "pipe.lode", 16384).least_ratio, 1);
}

struct Case {
  const char* name;
  Shape (*make)();
};

std::string nameOfCase(const testing::TestParamInfo<Case>& info) { return info.param.name; }

/// A store of a shape that is hard to measure.
class SoundStore : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    GetParam().make().write(input_);
    BuildOptions options;
    options.input = input_;
    options.output = store_;
    options.triangles_per_node = 256;
    build(options);
  }

  AgainstReport compare(const std::filesystem::path& store,
                        std::optional<ErrorWitness>* witness = nullptr) const {
    AgainstOptions options;
    options.store = store;
    options.input = input_;
    options.memory_bytes = 1 << 20;
    return compareWithInput(options, {}, witness);
  }

  /// Distance of a point in true coordinates from an LOD, or from the leaves below its node.
  static double distanceFrom(const store::Reader& reader, const ErrorWitness& witness) {
    test::TriangleSoup soup;
    const auto add = [&](const Node& node, uint32_t lod) {
      const test::TriangleSoup part = test::latticeSoup(store::readLod(reader, node, lod));
      soup.insert(soup.end(), part.begin(), part.end());
    };
    if (!witness.of_lod) add(*reader.find(witness.node), witness.lod);
    for (const Node& node : reader.nodes())
      if (witness.of_lod && node.isLeaf() && witness.node.contains(node.key)) add(node, 0);
    const Lattice& lattice = reader.summary().lattice;
    return test::DistanceField(soup).distance((witness.point - lattice.origin) / lattice.step) * lattice.step;
  }

  test::WorkFolder folder_;
  const std::filesystem::path input_ = folder_ / "a.ply", store_ = folder_ / "a.lode",
                              altered_ = folder_ / "b.lode";
};

TEST_P(SoundStore, isCalledSound) {
  const AgainstReport report = compare(store_);
  EXPECT_GT(report.lods, 0u);
  EXPECT_GE(report.least_ratio, 1);
}

TEST_P(SoundStore, isCalledUnsoundWithAWitnessPointOnceItsErrorsShrink) {
  const double least_ratio = compare(store_).least_ratio;
  alterStore(store_, altered_,
             [&](Node& node) {
               for (Lod& lod : node.lods) lod.error_model *= static_cast<float>(0.7 / least_ratio);
             },
             {});
  std::optional<ErrorWitness> witness;
  try {
    compare(altered_, &witness);
    FAIL() << "called sound; the least ratio was " << least_ratio;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFormat);
    EXPECT_NE(std::string(error.what()).find("(I4)"), std::string::npos) << error.what();
  }
  ASSERT_TRUE(witness);
  EXPECT_LT(witness->stored_error, 0.81 * witness->distance);
  EXPECT_NEAR(glm::distance(witness->point, witness->nearest), witness->distance, 1e-6 * witness->distance);
  if (!witness->on_boundary) {
    EXPECT_NEAR(distanceFrom(store::Reader(altered_), *witness), witness->distance, 1e-3 * witness->distance);
  }
}

INSTANTIATE_TEST_SUITE_P(HardShapes, SoundStore,
                         testing::Values(Case{"pipeline", pipeline},
                                         Case{"pipeAlongADiagonal", pipeAlongADiagonal},
                                         Case{"spring", spring}, Case{"needles", needles},
                                         Case{"kilometresAndMetres", kilometresAndMetres},
                                         Case{"flatTerrain", flatTerrain}, Case{"farApart", farApart},
                                         Case{"farFromTheOrigin", farFromTheOrigin}, Case{"comb", comb},
                                         Case{"stretchedSphere", stretchedSphere}),
                         nameOfCase);

}  // namespace
}  // namespace lode::ingest
