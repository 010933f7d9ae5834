#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/image/image.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/export.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/support/jpeg_files.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/textures/image_files.h"

namespace lode::ingest {
namespace {

using test::kMega;
using test::readBytes;

class BuildWithPreview : public testing::Test {
 protected:
  void makeSample(uint8_t attributes) const {
    SampleOptions sample;
    sample.kind = "asteroid";
    sample.triangles = 40000;
    sample.attributes.bits = attributes;
    writeSample(sample, folder_ / "a.ply");
  }
  BuildOptions options(const std::string& output = "a.lode") const {
    BuildOptions options;
    options.input = folder_ / "a.ply";
    options.output = folder_ / output;
    return options;
  }

  test::WorkFolder folder_;
};

TEST_F(BuildWithPreview, writesTheSameStoreWithAPreviewOnItsLattice) {
  makeSample(AttributeSet::kColour);
  build(options());
  BuildOptions with_preview = options("b.lode");
  with_preview.preview = folder_ / "b.preview.lode";
  bool is_there = false;
  build(with_preview, [&](std::string_view stage, double, uint64_t, uint64_t) {
    if (stage == "dereference") is_there = is_there || std::filesystem::exists(with_preview.preview);
  });
  EXPECT_TRUE(is_there) << "the preview must be complete before the next stage";
  EXPECT_EQ(readBytes(with_preview.output), readBytes(folder_ / "a.lode"));
  const store::Reader preview(with_preview.preview), store(with_preview.output);
  EXPECT_EQ(preview.summary().lattice, store.summary().lattice);
  EXPECT_GT(preview.summary().triangles, 0u);
  EXPECT_TRUE(preview.summary().attributes.has(AttributeSet::kColour));
}

TEST_F(BuildWithPreview, warnsAndBuildsOnIfThePreviewNeedsTooMuchMemory) {
  makeSample(0);
  BuildOptions given = options();
  given.preview = folder_ / "a.preview.lode";
  given.memory_bytes = 256 * kMega;
  const BuildReport report = build(given);
  EXPECT_FALSE(std::filesystem::exists(given.preview));
  EXPECT_TRUE(std::filesystem::exists(given.output));
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("no preview was written"), std::string::npos) << report.warnings[0];
}

TEST_F(BuildWithPreview, failsWithoutTrianglesAsWithoutAPreview) {
  std::ofstream(folder_ / "a.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n0 0 0\n2 0 0\n3 0 1 2\n";
  const auto messageOf = [this](const std::filesystem::path& preview) -> std::string {
    BuildOptions given = options();
    given.preview = preview;
    try {
      build(given);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const std::filesystem::path preview = folder_ / "a.preview.lode";
  EXPECT_NE(messageOf(preview), "");
  EXPECT_EQ(messageOf(preview), messageOf(""));
  EXPECT_FALSE(std::filesystem::exists(preview));
}

/// An image whose upper half has one colour and whose lower half has another.
Image twoHalves(glm::u8vec4 upper, glm::u8vec4 lower) {
  constexpr uint32_t kEdgePx = 64;
  Image image{glm::uvec2(kEdgePx), {}};
  for (uint32_t i = 0; i < kEdgePx * kEdgePx; ++i)
    image.texels.push_back(i < kEdgePx * kEdgePx / 2 ? upper : lower);
  return image;
}

constexpr glm::u8vec4 kRed(200, 30, 30, 255), kBlue(20, 40, 220, 255), kGreen(40, 180, 60, 255);

class TexturedPreview : public BuildWithPreview {
 protected:
  /// Returns the colours of the preview's vertices by their y coordinates, 0 or 1, and x coordinates.
  std::map<std::pair<int, int>, glm::ivec3> coloursOf(const std::string& ply) {
    std::ofstream(folder_ / "a.ply") << ply;
    BuildOptions given = options();
    given.preview = folder_ / "a.preview.lode";
    std::vector<std::string> warnings;
    buildPreview(given, warnings);
    const store::Reader preview(given.preview);
    EXPECT_TRUE(preview.summary().attributes.has(AttributeSet::kColour));
    const Mesh mesh = store::readLod(preview, preview.nodes().front(), 0);
    std::map<std::pair<int, int>, glm::ivec3> colours;
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const glm::dvec3 at = preview.summary().lattice.toWorld(unpackPosition(mesh.positions[i]));
      colours[{std::lround(at.y), std::lround(at.x)}] = glm::ivec3(mesh.vertex_attributes[i].colour);
    }
    return colours;
  }
  static void expectNear(glm::ivec3 colour, glm::u8vec4 wanted) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(colour[k], wanted[k], 6);
  }
};

TEST_F(TexturedPreview, hasTheColoursOfItsImage) {
  const std::string ply =
      "ply\nformat ascii 1.0\ncomment TextureFile a.img\nelement vertex 4\nproperty float x\n"
      "property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 0.1 0.1\n1 0 0 0.9 0.1\n1 1 0 0.9 0.9\n0 1 0 0.1 0.9\n4 0 1 2 3\n";
  const Image image = twoHalves(kRed, kBlue);
  for (const auto& file : {test::pngOf(image), test::jpegOf(image)}) {
    test::writeBytes(folder_ / "a.img", file);
    const auto colours = coloursOf(ply);
    ASSERT_EQ(colours.size(), 4u);
    for (const auto& [place, colour] : colours) expectNear(colour, place.first == 1 ? kRed : kBlue);
  }
}

TEST_F(TexturedPreview, hasTheColoursOfTheImageOfEachFace) {
  test::writeBytes(folder_ / "a.png", test::pngOf(twoHalves(kRed, kRed)));
  test::writeBytes(folder_ / "b.png", test::pngOf(twoHalves(kBlue, kGreen)));
  const auto colours = coloursOf(
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b.png\nelement vertex 6\n"
      "property float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n"
      "end_header\n0 0 0\n1 0 0\n0 1 0\n4 0 0\n5 0 0\n4 1 0\n"
      "3 0 1 2 6 0.1 0.1 0.9 0.1 0.1 0.9 0\n3 3 4 5 6 0.1 0.1 0.9 0.1 0.1 0.9 1\n");
  ASSERT_EQ(colours.size(), 6u);
  for (const auto& [place, colour] : colours)
    expectNear(colour, place.second < 2 ? kRed : place.first == 1 ? kBlue : kGreen);
}

TEST_F(TexturedPreview, multipliesTheColoursOfTheFileAndOfItsImage) {
  test::writeBytes(folder_ / "a.png", test::pngOf(twoHalves(kRed, kRed)));
  const auto colours = coloursOf(
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nproperty float s\nproperty float t\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0 0 0 128 128 128\n"
      "1 0 0 1 0 128 128 128\n0 1 0 0 1 128 128 128\n3 0 1 2\n");
  ASSERT_EQ(colours.size(), 3u);
  for (const auto& [place, colour] : colours) expectNear(colour, {100, 15, 15, 255});
}

TEST_F(BuildWithPreview, writesOnlyAPreview) {
  makeSample(0);
  BuildOptions given = options();
  given.preview = folder_ / "a.preview.lode";
  std::vector<std::string> warnings;
  buildPreview(given, warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_FALSE(std::filesystem::exists(given.output));
  EXPECT_EQ(store::Reader(given.preview).nodes().size(), 1u);
}

}  // namespace
}  // namespace lode::ingest
