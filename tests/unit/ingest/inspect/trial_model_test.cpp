#include "server/ingest/inspect/trial_model.h"

#include "server/sample/sample.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {
namespace {

class TrialModelOfAPly : public testing::Test {
 protected:
  PlyContent trialOf(const std::filesystem::path& input, uint64_t faces, uint64_t stretches = 1) {
    const uint64_t all = readPly(input).faces.size();
    written_ = writeTrialModel(input, all, faces, stretches, folder_.path() / "trial.ply");
    return readPly(folder_.path() / "trial.ply");
  }

  PlyFolder folder_;
  TrialModel written_;
};

TEST_F(TrialModelOfAPly, isTheWholeModelIfThatIsSmall) {
  const std::filesystem::path input = folder_.path() / "a.ply";
  writeSample(
      {"terrain", 200, {AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture}, 1, 1},
      input);
  const PlyContent whole = readPly(input), trial = trialOf(input, 1000);
  EXPECT_EQ(trial.faces, whole.faces);
  EXPECT_EQ(trial.attributes.bits, whole.attributes.bits);
  ASSERT_EQ(trial.vertices.size(), whole.vertices.size());
  for (size_t i = 0; i < whole.vertices.size(); ++i) {
    EXPECT_EQ(trial.vertices[i].position, whole.vertices[i].position);
    EXPECT_EQ(trial.vertices[i].normal, whole.vertices[i].normal);
    EXPECT_EQ(trial.vertices[i].colour, whole.vertices[i].colour);
    EXPECT_EQ(trial.vertices[i].texture, whole.vertices[i].texture);
  }
}

TEST_F(TrialModelOfAPly, samplesTheMiddlesOfEqualPartsWithOnlyTheirVertices) {
  const std::filesystem::path input = folder_.path() / "a.ply";
  writeSample({"terrain", 20'000, {}, 1, 1}, input);
  const PlyContent whole = readPly(input), trial = trialOf(input, 4000, 2);
  ASSERT_EQ(trial.faces.size(), 4000u);
  EXPECT_EQ(written_.faces, 4000u);
  EXPECT_EQ(written_.vertices, trial.vertices.size());
  EXPECT_LT(trial.vertices.size(), 2600u);
  for (size_t i = 0; i < trial.faces.size(); ++i) {
    const size_t in_whole = i < 2000 ? 4000 + i : 14'000 + i - 2000;
    for (size_t corner = 0; corner < 3; ++corner) {
      EXPECT_EQ(trial.vertices[trial.faces[i][corner]].position,
                whole.vertices[whole.faces[in_whole][corner]].position);
    }
  }
}

TEST_F(TrialModelOfAPly, keepsCoordinatesAndMaterialsOfCornersAndNoTextures) {
  const std::filesystem::path input = folder_.write(
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty float "
      "y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
      "property list uchar float texcoord\nproperty int texnumber\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n3 0 1 2 6 0 0 1 0 0.5 1 1\n");
  const PlyContent whole = readPly(input), trial = trialOf(input, 10);
  EXPECT_EQ(trial.faces, whole.faces);
  EXPECT_EQ(trial.texture, whole.texture);
  EXPECT_EQ(trial.materials, whole.materials);
  EXPECT_TRUE(trial.header.texture_files.empty());
}

TEST_F(TrialModelOfAPly, keepsColoursOfFaces) {
  const std::filesystem::path input = folder_.write(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty float red\nproperty float green\n"
      "property float blue\nproperty float alpha\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 1 0.5 0 1\n3 0 1 2 0 0 1 0.25\n");
  const PlyContent whole = readPly(input), trial = trialOf(input, 10);
  EXPECT_EQ(trial.faces, whole.faces);
  EXPECT_EQ(trial.colours, whole.colours);
  EXPECT_EQ(trial.attributes, whole.attributes);
}

}  // namespace
}  // namespace lode::ingest
