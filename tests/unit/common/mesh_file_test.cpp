#include "common/io/mesh_file.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/io/output_target.h"
#include "tests/support/test_meshes.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

TEST(MeshFile, hasTheFormatThatItsEndingNames) {
  EXPECT_EQ(meshFormatOf("a/cut.ply"), MeshFormat::kPly);
  EXPECT_EQ(meshFormatOf("cut.PLY"), MeshFormat::kPly);
  EXPECT_EQ(meshFormatOf("cut.obj"), MeshFormat::kObj);
  EXPECT_EQ(meshFormatOf("cut.v2.Glb"), MeshFormat::kGlb);
}

TEST(MeshFile, isAPlyInADeviceWithoutAnEnding) { EXPECT_EQ(meshFormatOf("/dev/null"), MeshFormat::kPly); }

TEST(MeshFile, isRefusedUnderAnotherEndingWithTheKnownEndings) {
  const test::WorkFolder folder;
  for (const char* name : {"cut.stl", "cut.gltf", "cut.ply.gz", "cut", "a.obj/cut"}) {
    try {
      writeMesh(folder / name, test::makeGrid(1, 1), {});
      ADD_FAILURE() << name << " was written";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      EXPECT_NE(std::string(error.what()).find(".ply, .obj or .glb"), std::string::npos) << error.what();
    }
  }
  EXPECT_TRUE(folder.contents().empty());
}

TEST(MeshFile, isNotWrittenIfTheMeshLacksAttributes) {
  const test::WorkFolder folder;
  Mesh mesh = test::makeGrid(1, 1);
  mesh.attributes.bits = AttributeSet::kNormal;
  for (const char* name : {"cut.ply", "cut.obj", "cut.glb"})
    EXPECT_THROW(writeMesh(folder / name, mesh, {}), Error) << name;
  EXPECT_TRUE(folder.contents().empty());
}

TEST(MeshFile, namesTheFolderThatIsMissing) {
  const test::WorkFolder folder;
  for (const char* name : {"missing/cut.ply", "missing/cut.obj", "missing/cut.glb"}) {
    try {
      writeMesh(folder / name, test::makeGrid(1, 1), {});
      ADD_FAILURE() << name << " was written";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kIo);
      EXPECT_NE(std::string(error.what()).find("missing"), std::string::npos) << error.what();
    }
  }
}

TEST(FileEnding, isTheLastInSmallLetters) { EXPECT_EQ(fileEnding("/a.b/model.LODE.Png"), ".png"); }

TEST(FileEnding, isEmptyOfANameWithoutOne) { EXPECT_EQ(fileEnding("/a.b/model"), ""); }

}  // namespace
}  // namespace lode
