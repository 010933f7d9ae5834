// Models whose faces have colours, from PLY to store and back.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/inspect/against.h"
#include "server/ingest/pipeline/build.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using test::readBytes;

constexpr uint32_t kRedFace = 0xc01010ff, kBlueFace = 0x1010c0ff;

uint32_t codeOf(const VertexAttributes& attributes) {
  const glm::u8vec4 c = attributes.colour;
  return uint32_t{c.r} << 24 | uint32_t{c.g} << 16 | uint32_t{c.b} << 8 | c.a;
}

class FaceColours : public testing::Test {
 protected:
  static constexpr int kSide = 32;

  /// Writes a hilly grid of quads. @param colour  returns RGBA of the quad at (x, y); null: no colours.
  std::filesystem::path writeGrid(const std::function<uint32_t(int, int)>& colour) const {
    const std::filesystem::path path = folder_ / "grid.ply";
    std::ofstream file(path);
    file << "ply\nformat ascii 1.0\nelement vertex " << (kSide + 1) * (kSide + 1)
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << kSide * kSide
         << "\nproperty list uchar int vertex_indices\n";
    if (colour)
      file << "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    file << "end_header\n";
    for (int y = 0; y <= kSide; ++y)
      for (int x = 0; x <= kSide; ++x)
        file << x << ' ' << y << ' ' << 0.5 * std::sin(0.4 * x) * std::cos(0.3 * y) << '\n';
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int first = y * (kSide + 1) + x;
        file << "4 " << first << ' ' << first + 1 << ' ' << first + kSide + 2 << ' ' << first + kSide + 1;
        if (colour) {
          const uint32_t c = colour(x, y);
          file << ' ' << (c >> 24) << ' ' << (c >> 16 & 255) << ' ' << (c >> 8 & 255) << ' ' << (c & 255);
        }
        file << '\n';
      }
    return path;
  }

  std::filesystem::path builtGrid(const std::function<uint32_t(int, int)>& colour, unsigned threads = 1,
                                  uint64_t memory_bytes = 0) const {
    BuildOptions options;
    options.input = writeGrid(colour);
    options.output = folder_ / "grid.lode";
    options.triangles_per_node = 256;
    options.threads = threads;
    options.memory_bytes = memory_bytes;
    build(options);
    return options.output;
  }

  /// Returns the colours of a store's triangles in all LODs. Fails the test if a triangle has several.
  std::set<uint32_t> coloursOf(const store::Reader& reader) const {
    std::set<uint32_t> colours;
    for (const Node& node : reader.nodes())
      for (uint32_t lod = 0; lod < node.lods.size(); ++lod) {
        const Mesh mesh = store::readLod(reader, node, lod);
        for (const glm::u32vec3& t : mesh.triangles) {
          for (int k = 0; k < 3; ++k) colours.insert(codeOf(mesh.vertex_attributes[t[k]]));
          EXPECT_EQ(codeOf(mesh.vertex_attributes[t.x]), codeOf(mesh.vertex_attributes[t.y]));
          EXPECT_EQ(codeOf(mesh.vertex_attributes[t.y]), codeOf(mesh.vertex_attributes[t.z]));
        }
      }
    return colours;
  }

  void expectSound(const std::filesystem::path& store) const {
    EXPECT_GT(store::verifyStore(store, {.random_cuts = 5}).triangles, 0u);
    AgainstOptions against;
    against.store = store;
    against.input = folder_ / "grid.ply";
    EXPECT_EQ(compareWithInput(against).triangles, uint64_t{2 * kSide * kSide});
  }

  /// Returns the triangles of the root's coarsest LOD.
  uint64_t trianglesAtTheRoot(const store::Reader& reader) const {
    const Node& root = reader.nodes().front();
    return store::readLod(reader, root, static_cast<uint32_t>(root.lods.size()) - 1).triangles.size();
  }

  test::WorkFolder folder_;
};

TEST_F(FaceColours, keepTheirBordersHardInAllLods) {
  const auto store = builtGrid([](int x, int) { return x < kSide / 2 ? kRedFace : kBlueFace; });
  const store::Reader reader(store);
  EXPECT_TRUE(reader.summary().attributes.has(AttributeSet::kColour | AttributeSet::kAlpha));
  EXPECT_EQ(coloursOf(reader), (std::set<uint32_t>{kRedFace, kBlueFace}));
  expectSound(store);
  const uint64_t coarsest = trianglesAtTheRoot(reader);
  EXPECT_LE(coarsest, trianglesAtTheRoot(store::Reader(builtGrid({}))) * 5 / 4);
}

TEST_F(FaceColours, keepIslandsOfAColour) {
  const auto store = builtGrid([](int x, int y) { return (x / 8 + y / 8) % 2 == 0 ? kRedFace : kBlueFace; });
  const store::Reader reader(store);
  EXPECT_EQ(coloursOf(reader), (std::set<uint32_t>{kRedFace, kBlueFace}));
  expectSound(store);
}

TEST_F(FaceColours, addNoSeamsIfAllEqual) {
  const auto verticesOf = [](const store::Reader& reader) {
    uint64_t vertices = 0;
    for (const Node& node : reader.nodes())
      for (uint32_t lod = 0; lod < node.lods.size(); ++lod)
        vertices += node.isLeaf() && lod == 0 ? store::readLod(reader, node, lod).positions.size() : 0;
    return vertices;
  };
  const uint64_t grey = verticesOf(store::Reader(builtGrid({})));
  const store::Reader reader(builtGrid([](int, int) { return kRedFace; }));
  EXPECT_EQ(verticesOf(reader), grey);
  EXPECT_EQ(coloursOf(reader), std::set<uint32_t>{kRedFace});
}

TEST_F(FaceColours, giveASoundStoreIfEveryFaceDiffers) {
  std::mt19937 random(41);
  const auto store = builtGrid([&](int, int) { return static_cast<uint32_t>(random()) | 255u; });
  const store::Reader reader(store);
  EXPECT_GT(coloursOf(reader).size(), 100u);
  EXPECT_LT(trianglesAtTheRoot(reader), uint64_t{kSide * kSide}) << "simplifies, though every edge is a seam";
  expectSound(store);
}

TEST_F(FaceColours, giveTheSameBytesForAnyNumberOfThreadsAndAnyMemory) {
  const auto colour = [](int x, int y) {
    return (static_cast<uint32_t>(x / 3) * 0x10203000u + static_cast<uint32_t>(y / 5) * 0x50000u) | 255u;
  };
  const std::string expected = readBytes(builtGrid(colour));
  EXPECT_TRUE(readBytes(builtGrid(colour, 8)) == expected);
  EXPECT_TRUE(readBytes(builtGrid(colour, 2, 1 << 16)) == expected) << "sorted on disk";
}

TEST_F(FaceColours, surviveAnInterruptionInEachStage) {
  BuildOptions options;
  options.input = writeGrid([](int x, int y) { return x < y ? kRedFace : kBlueFace; });
  options.output = folder_ / "a.lode";
  options.triangles_per_node = 256;
  build(options);
  const std::string expected = readBytes(options.output);
  options.resume = true;
  for (const char* stage : {"scan", "dereference", "partition", "simplify"}) {
    std::filesystem::remove(options.output);
    EXPECT_THROW(build(options,
                       [&](std::string_view now, double, uint64_t, uint64_t) {
                         if (now == stage) throw Error(ErrorCode::kIo, "asked to end");
                       }),
                 Error);
    build(options);
    EXPECT_TRUE(readBytes(options.output) == expected) << stage;
  }
}

}  // namespace
}  // namespace lode::ingest
