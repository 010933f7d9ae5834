#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/pipeline/build.h"
#include "server/sample/sample.h"
#include "server/store/reader.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

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
