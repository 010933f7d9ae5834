// A model in several PLY files, as agencies and scanners deliver tiles.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/ingest/soup/input_images.h"
#include "server/sample/sample.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "server/store/verify.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

struct Triangles {
  std::vector<glm::vec3> vertices;
  std::vector<glm::u32vec3> faces;
};

Triangles readTriangles(const std::filesystem::path& path) {
  Triangles read;
  PlyReader reader(path, {});
  reader.read(
      [&](uint64_t, std::span<const PlyVertex> vertices) {
        for (const PlyVertex& vertex : vertices) read.vertices.emplace_back(vertex.position);
      },
      [&](const PlyFaces& faces) {
        for (size_t i = 0; i < faces.corners.size(); i += 3)
          read.faces.emplace_back(faces.corners[i], faces.corners[i + 1], faces.corners[i + 2]);
      });
  return read;
}

void write(const std::filesystem::path& path, const Triangles& mesh) {
  std::ofstream file(path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.faces.size()
       << "\nproperty list uchar uint vertex_indices\nend_header\n";
  file.write(reinterpret_cast<const char*>(mesh.vertices.data()),
             static_cast<std::streamsize>(mesh.vertices.size() * sizeof(glm::vec3)));
  for (const glm::u32vec3& face : mesh.faces) {
    file.put(3);
    file.write(reinterpret_cast<const char*>(&face), sizeof face);
  }
}

/// Returns the triangles with only the vertices that they use.
Triangles compact(const Triangles& whole, std::span<const glm::u32vec3> faces) {
  Triangles tile;
  std::map<uint32_t, uint32_t> numbers;
  for (const glm::u32vec3& face : faces) {
    glm::u32vec3 renumbered;
    for (int k = 0; k < 3; ++k) {
      const auto [at, is_new] = numbers.emplace(face[k], static_cast<uint32_t>(tile.vertices.size()));
      if (is_new) tile.vertices.push_back(whole.vertices[face[k]]);
      renumbered[k] = at->second;
    }
    tile.faces.push_back(renumbered);
  }
  return tile;
}

class SeveralInputs : public testing::Test {
 protected:
  SeveralInputs() {
    for (const char* name : {"one", "tiles", "parts"}) std::filesystem::create_directory(folder_ / name);
  }

  BuildOptions options(const std::vector<std::filesystem::path>& inputs, std::string_view output) const {
    BuildOptions options;
    options.input = inputs.front();
    options.more_inputs.assign(inputs.begin() + 1, inputs.end());
    options.output = folder_ / output;
    options.triangles_per_node = 256;
    options.memory_bytes = 64 * kMega;
    options.threads = 2;
    return options;
  }

  /// Cuts a terrain into 8 x 8 tiles with common borders, in a random order, and writes the same triangles in
  /// the same order into whole.ply. @return the tiles.
  std::vector<std::filesystem::path> makeTiles(uint32_t seed) const {
    SampleOptions sample;
    sample.kind = "terrain";
    sample.triangles = 20000;
    writeSample(sample, folder_ / "terrain.ply");
    const Triangles whole = readTriangles(folder_ / "terrain.ply");
    glm::vec3 least(1e9F), most(-1e9F);
    for (const glm::vec3& vertex : whole.vertices) {
      least = glm::min(least, vertex);
      most = glm::max(most, vertex);
    }
    std::vector<std::vector<glm::u32vec3>> tiles(64);
    for (const glm::u32vec3& face : whole.faces) {
      const glm::vec3 centre =
          (whole.vertices[face.x] + whole.vertices[face.y] + whole.vertices[face.z]) / 3.0F;
      const glm::uvec3 at(glm::min(glm::vec3(7), 8.0F * (centre - least) / (most - least)));
      tiles[8 * at.y + at.x].push_back(face);
    }
    std::shuffle(tiles.begin(), tiles.end(), std::mt19937(seed));
    Triangles ordered{whole.vertices, {}};
    std::vector<std::filesystem::path> paths;
    for (const std::vector<glm::u32vec3>& tile : tiles) {
      paths.push_back(folder_ / ("tile" + std::to_string(paths.size()) + ".ply"));
      write(paths.back(), compact(whole, tile));
      ordered.faces.insert(ordered.faces.end(), tile.begin(), tile.end());
    }
    write(folder_ / "whole.ply", ordered);
    return paths;
  }

  std::string failure(const BuildOptions& options) const {
    try {
      build(options);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  test::WorkFolder folder_;
};

TEST_F(SeveralInputs, giveTheBytesOfOneFileWithTheSameTriangles) {
  for (const uint32_t seed : {1u, 2u}) {
    const auto tiles = makeTiles(seed);
    build(options({folder_ / "whole.ply"}, "one/model.lode"));
    build(options(tiles, "tiles/model.lode"));
    EXPECT_TRUE(readBytes(folder_ / "tiles/model.lode") == readBytes(folder_ / "one/model.lode")) << seed;
  }
}

TEST_F(SeveralInputs, meetWithoutACrack) {
  const auto tiles = makeTiles(3);
  build(options({folder_ / "terrain.ply"}, "one/model.lode"));
  build(options(tiles, "tiles/model.lode"));
  const store::VerifyReport one = store::verifyStore(folder_ / "one/model.lode");
  const store::VerifyReport of_tiles = store::verifyStore(folder_ / "tiles/model.lode");
  EXPECT_GT(one.open_edges, 0u) << "the rim of the terrain";
  EXPECT_EQ(of_tiles.open_edges, one.open_edges);
}

TEST_F(SeveralInputs, canBeBuiltInParts) {
  const auto tiles = makeTiles(4);
  build(options(tiles, "one/model.lode"));
  BuildOptions part = options(tiles, "parts/model.lode");
  part.tasks = 2;
  for (const auto& [kind, task] : {std::pair{BuildPart::kPrepare, 0u},
                                   {BuildPart::kSimplify, 1u},
                                   {BuildPart::kSimplify, 0u},
                                   {BuildPart::kFinish, 0u}}) {
    part.part = kind;
    part.task = task;
    build(part);
  }
  EXPECT_TRUE(readBytes(folder_ / "parts/model.lode") == readBytes(folder_ / "one/model.lode"));
}

TEST_F(SeveralInputs, areRefusedIfTheirPropertiesDiffer) {
  const auto tiles = makeTiles(5);
  SampleOptions sample;
  sample.kind = "asteroid";
  sample.triangles = 1000;
  sample.attributes.bits = AttributeSet::kColour;
  writeSample(sample, folder_ / "coloured.ply");
  const std::string message = failure(options({tiles[0], folder_ / "coloured.ply"}, "a.lode"));
  EXPECT_NE(message.find("coloured.ply: has other properties than"), std::string::npos) << message;
}

TEST_F(SeveralInputs, areNamedInErrors) {
  const auto tiles = makeTiles(6);
  std::filesystem::resize_file(tiles[7], std::filesystem::file_size(tiles[7]) - 5);
  EXPECT_NE(failure(options(tiles, "a.lode")).find("tile7.ply"), std::string::npos);
  std::filesystem::remove(tiles[9]);
  EXPECT_NE(failure(options(tiles, "a.lode")).find("tile9.ply"), std::string::npos);
}

TEST_F(SeveralInputs, areComparedWhenABuildResumes) {
  const auto tiles = makeTiles(7);
  BuildOptions resumed = options(tiles, "a.lode");
  resumed.resume = true;
  EXPECT_THROW(build(resumed,
                     [](std::string_view stage, double, uint64_t, uint64_t) {
                       if (stage == "simplify") throw Error(ErrorCode::kIo, "asked to end");
                     }),
               Error);
  BuildOptions fewer = resumed;
  fewer.more_inputs.pop_back();
  EXPECT_NE(failure(fewer).find("it began with 64 inputs"), std::string::npos);
  BuildOptions other = resumed;
  std::swap(other.more_inputs[3], other.more_inputs[4]);
  EXPECT_NE(failure(other).find("it began with the input"), std::string::npos);
  EXPECT_EQ(failure(resumed), "");
}

/// A square of two triangles from x to x + 1, with an image.
void writeTextured(const std::filesystem::path& path, int x, const std::string& image, bool has_number) {
  const std::string left = std::to_string(x), right = std::to_string(x + 1);
  std::ofstream(path) << "ply\nformat ascii 1.0\ncomment TextureFile " << image
                      << "\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                         "property float s\nproperty float t\nelement face 2\n"
                         "property list uchar int vertex_indices\n"
                      << (has_number ? "property int texnumber\n" : "") << "end_header\n"
                      << left << " 0 0 0 0\n"
                      << right << " 0 0 1 0\n"
                      << right << " 1 0 1 1\n"
                      << left << " 1 0 0 1\n3 0 1 2" << (has_number ? " 0" : "") << "\n3 0 2 3"
                      << (has_number ? " 0" : "") << "\n";
}

/// Returns the number of the image of a triangle whose corners lie between x and x + 1, or -1.
int imageAt(const store::Reader& store, double x) {
  const Mesh mesh = store::readLod(store, store.nodes().front(), 0);
  for (const glm::u32vec3& corners : mesh.triangles) {
    bool is_inside = true;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 at = store.summary().lattice.toWorld(unpackPosition(mesh.positions[corners[k]]));
      is_inside = is_inside && at.x > x - 0.01 && at.x < x + 1.01;
    }
    const uint16_t material = mesh.vertex_attributes[corners.x].material;
    if (is_inside) return material == kNoMaterial ? -1 : material;
  }
  return -1;
}

TEST_F(SeveralInputs, showEachFaceWithTheImageOfItsFile) {
  for (const bool has_number : {true, false}) {
    for (const int side : {64, 32, 16})
      test::writeBytes(folder_ / (std::to_string(side) + ".png"), test::pngOf(test::makePhoto(side, side)));
    std::vector<std::filesystem::path> inputs;
    for (const int side : {64, 32, 64, 16}) {
      inputs.push_back(folder_ / ("i" + std::to_string(inputs.size()) + ".ply"));
      writeTextured(inputs.back(), static_cast<int>(inputs.size()) - 1, std::to_string(side) + ".png",
                    has_number);
    }
    build(options(inputs, "m.lode"));
    const store::Reader store(folder_ / "m.lode");
    EXPECT_EQ(imageAt(store, 0), 0);
    EXPECT_EQ(imageAt(store, 1), 1);
    EXPECT_EQ(imageAt(store, 2), 0);
    EXPECT_EQ(imageAt(store, 3), 2);
  }
}

TEST_F(SeveralInputs, shareTheirImages) {
  test::writeBytes(folder_ / "one.png", test::pngOf(test::makePhoto(64, 64)));
  test::writeBytes(folder_ / "two.png", test::pngOf(test::makePhoto(32, 32)));
  std::filesystem::create_directory(folder_ / "other");
  test::writeBytes(folder_ / "other/one.png", test::pngOf(test::makePhoto(16, 16)));
  writeTextured(folder_ / "a.ply", 0, "one.png", true);
  writeTextured(folder_ / "b.ply", 1, "two.png", true);
  writeTextured(folder_ / "c.ply", 2, "one.png", true);
  writeTextured(folder_ / "other/d.ply", 3, "one.png", true);
  const std::vector<std::filesystem::path> inputs{folder_ / "a.ply", folder_ / "b.ply", folder_ / "c.ply",
                                                  folder_ / "other/d.ply"};
  const InputImages images = listImages(inputs, {});
  EXPECT_EQ(images.images.size(), 3u);
  EXPECT_EQ(images.of_file, (std::vector<std::vector<uint16_t>>{{0}, {1}, {0}, {2}}));
  const BuildReport report = build(options(inputs, "m.lode"));
  EXPECT_EQ(report.texture_files, (std::vector<std::string>{"one.png", "two.png", "one.png"}));
  const store::Reader store(folder_ / "m.lode");
  ASSERT_EQ(store.textures().textures.size(), 3u);
  EXPECT_EQ(store.textures().textures[0].width, 64u);
  EXPECT_EQ(store.textures().textures[1].width, 32u);
  EXPECT_EQ(store.textures().textures[2].width, 16u);
}

}  // namespace
}  // namespace lode::ingest
