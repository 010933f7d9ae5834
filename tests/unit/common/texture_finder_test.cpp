#include "common/io/texture_finder.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

class TextureFinderOf : public testing::Test {
 protected:
  void SetUp() override { fs::create_directory(models_); }

  static void write(const fs::path& file) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "image";
  }
  void writeAll(const std::vector<std::string>& names) const {
    for (const std::string& name : names) write(models_ / name);
  }

  TextureFile find(const std::string& name, const fs::path& textures = {}) const {
    return TextureFinder(models_ / "a.ply", textures).find(name);
  }
  std::string problemOf(const std::string& name) const { return find(name).problem; }
  /// Returns the path of the image relative to the models' folder; empty if there is a problem.
  std::string placeOf(const std::string& name, const fs::path& textures = {}) const {
    const TextureFile file = find(name, textures);
    EXPECT_EQ(file.path.empty(), !file.problem.empty()) << name;
    return file.path.empty() ? "" : file.path.lexically_relative(fs::canonical(models_)).string();
  }
  void expectNamed(const std::string& name, const std::vector<std::string>& words) const {
    const std::string problem = problemOf(name);
    for (const std::string& word : words)
      EXPECT_NE(problem.find(word), std::string::npos) << name << ": " << problem;
  }

  test::WorkFolder folder_;
  fs::path models_ = folder_ / "models";
};

TEST_F(TextureFinderOf, aPlyFindsImagesBesideTheFileAndBelow) {
  writeAll({"two words.png", "maps/b.png"});
  fs::create_symlink("maps/b.png", models_ / "inner.png");
  for (const char* name : {"two words.png", "maps/b.png", "inner.png"})
    EXPECT_EQ(problemOf(name), "") << name;
}

TEST_F(TextureFinderOf, aPlyReadsNothingOutsideItsFolder) {
  write(folder_ / "outside.png");
  fs::create_symlink(folder_ / "outside.png", models_ / "link.png");
  fs::create_directory_symlink("..", models_ / "up");
  fs::create_directories(models_ / "maps");
  for (const std::string& name :
       {(folder_ / "outside.png").string(), std::string("../outside.png"),
        std::string("maps/../../outside.png"), std::string("link.png"), std::string("LINK.PNG"),
        std::string("up/outside.png"), std::string("C:\\up\\outside.png"), std::string("OUTSIDE.PNG")})
    EXPECT_NE(problemOf(name).find("PLY file's folder"), std::string::npos)
        << name << ": " << problemOf(name);
}

TEST_F(TextureFinderOf, aLinkToAPlyLooksBesideTheLinkFirstAndThenBesideTheFile) {
  writeAll({"a.ply", "a.png"});
  fs::create_directory(folder_ / "links");
  fs::create_symlink("../models/a.ply", folder_ / "links" / "b.ply");
  const auto found = [&](const std::string& name) {
    return TextureFinder(folder_ / "links" / "b.ply").find(name);
  };
  EXPECT_EQ(found("a.png").path, fs::canonical(models_ / "a.png"));
  write(folder_ / "links" / "a.png");
  EXPECT_EQ(found("a.png").path, fs::canonical(folder_ / "links" / "a.png"));
  EXPECT_EQ(found("../models/a.png").path, fs::canonical(folder_ / "links" / "a.png"))
      << "the last component, not the path out of the folder";
  const std::string problem = found("gone.png").problem;
  for (const auto& searched : {models_, folder_ / "links"})
    EXPECT_NE(problem.find(fs::canonical(searched).string() + "'"), std::string::npos) << problem;
}

TEST_F(TextureFinderOf, aMissingImageNamesTheFolderAndTheRemedies) {
  expectNamed("gone.png", {"'" + fs::canonical(models_).string() + "'", "PLY file's folder", "--textures"});
}

TEST_F(TextureFinderOf, aWholePathIntoThePlysFolderFindsItsFile) {
  writeAll({"maps/a.png", "a.png"});
  EXPECT_EQ(placeOf((models_ / "maps" / "a.png").string()), "maps/a.png");
}

TEST_F(TextureFinderOf, aPathOfAnotherMachineFindsItsLastComponentBesideThePly) {
  writeAll({"tex.png", "sub.png", "größe.png"});
  for (const char* name :
       {"C:\\Users\\someone\\scan\\tex.png", "C:/Users/someone/tex.png", "/home/someone/scan/tex.png",
        "\\\\server\\share\\tex.png", "textures\\tex.png", "../maps/tex.png", "..\\maps\\tex.png",
        "file:///C:/scan/tex.png", ".\\tex.png", "C:tex\\..\\tex.png"})
    EXPECT_EQ(placeOf(name), "tex.png") << name;
  EXPECT_EQ(placeOf("textures\\sub.png"), "sub.png");
  EXPECT_EQ(placeOf("D:\\Modelle\\größe.png"), "größe.png");
}

TEST_F(TextureFinderOf, thePathsLongestEndThatExistsIsTaken) {
  writeAll({"tex.png", "maps/tex.png", "scan/maps/tex.png"});
  EXPECT_EQ(placeOf("C:\\scan\\maps\\tex.png"), "scan/maps/tex.png");
  EXPECT_EQ(placeOf("C:\\other\\maps\\tex.png"), "maps/tex.png");
  EXPECT_EQ(placeOf("maps\\tex.png"), "maps/tex.png");
  EXPECT_EQ(placeOf("C:\\other\\tex.png"), "tex.png");
}

TEST_F(TextureFinderOf, theOnlyFileOfTheNameInASubfolderIsTaken) {
  writeAll({"data/textures/tex.png"});
  EXPECT_EQ(placeOf("tex.png"), "data/textures/tex.png");
  EXPECT_EQ(placeOf("C:\\x\\tex.png"), "data/textures/tex.png");
  writeAll({"backup/tex.png"});
  EXPECT_EQ(placeOf("tex.png"), "");
  expectNamed("tex.png", {"matches 2 files", "'backup/tex.png', 'data/textures/tex.png'", "--textures"});
}

TEST_F(TextureFinderOf, anotherCaseIsTakenIfItIsTheOnlyMatch) {
  writeAll({"tex.png"});
  EXPECT_EQ(placeOf("TEX.PNG"), "tex.png");
  EXPECT_EQ(placeOf("C:\\Maps\\Tex.Png"), "tex.png");
  writeAll({"tex.PNG"});
  EXPECT_EQ(placeOf("TEX.PNG"), "");
  expectNamed("TEX.PNG", {"matches 2 files", "'tex.PNG', 'tex.png'"});
  writeAll({"sub/TEX.PNG"});
  EXPECT_EQ(placeOf("TEX.PNG"), "sub/TEX.PNG") << "the name itself comes before another case";
}

TEST_F(TextureFinderOf, anImageWithAnotherEndingIsNamedButNotTaken) {
  writeAll({"maps/Tex.jpg", "tex.txt", "tex.obj"});
  EXPECT_EQ(placeOf("tex.png"), "");
  expectNamed("tex.png", {"'maps/Tex.jpg'"});
  EXPECT_EQ(problemOf("tex.png").find("tex.txt"), std::string::npos);
}

TEST_F(TextureFinderOf, theFolderOfTexturesIsSearchedFirst) {
  writeAll({"tex.png"});
  const fs::path textures = folder_ / "textures";
  write(textures / "tex.png");
  write(textures / "deep" / "other.png");
  EXPECT_EQ(find("tex.png", textures).path, fs::canonical(textures / "tex.png"));
  EXPECT_EQ(find("C:\\x\\OTHER.png", textures).path, fs::canonical(textures / "deep" / "other.png"));
  EXPECT_EQ(placeOf("tex.png", folder_ / "gone"), "tex.png");
  EXPECT_EQ(find("gone.png", textures).problem.find("--textures"), std::string::npos);
}

TEST_F(TextureFinderOf, aSearchSkipsHiddenFoldersLinksAndDeepFolders) {
  writeAll({".cache/tex.png", ".tex.png", "1/2/3/4/deep.png", "1/2/3/4/5/deeper.png"});
  write(folder_ / "outside" / "linked.png");
  fs::create_directory_symlink(folder_ / "outside", models_ / "link");
  fs::create_directory_symlink(models_, models_ / "loop");
  EXPECT_EQ(placeOf("C:\\x\\tex.png"), "");
  EXPECT_EQ(placeOf("C:\\.cache\\tex.png"), "");
  EXPECT_EQ(placeOf("linked.png"), "");
  EXPECT_EQ(placeOf("deep.png"), "1/2/3/4/deep.png");
  EXPECT_EQ(placeOf("deeper.png"), "");
}

TEST_F(TextureFinderOf, aSearchEndsAtItsLimitOfEntriesWhateverTheOrderOfTheList) {
  writeAll({"a/tex.png", "b/other.png", "TEX2.png"});
  for (size_t i = 0; i < FolderIndex::kMaxEntries; ++i)
    fs::create_symlink("x", models_ / "b" / std::to_string(i));
  EXPECT_EQ(placeOf("tex.png"), "a/tex.png");
  EXPECT_EQ(placeOf("tex2.png"), "TEX2.png");
  EXPECT_EQ(placeOf("other.png"), "");
  expectNamed("other.png", {"the search ended after 20000"});
}

TEST_F(TextureFinderOf, anInvalidImageNameIsRefused) {
  writeAll({"nul", "sub/tex.png"});
  fs::create_directories(models_ / "folder.png");
  ASSERT_EQ(mkfifo((models_ / "pipe.png").c_str(), 0600), 0);
  std::string deep = "tex.jpg";
  for (int i = 0; i < 20'000; ++i) deep.insert(0, "a/");
  for (const std::string& name :
       {std::string("folder.png"), std::string("missing.png"), std::string("nul\0.png", 8),
        std::string(5000, 'x'), std::string("pipe.png"), std::string("PIPE.png"), std::string("/dev/zero"),
        std::string("/dev/stdin"), std::string(".."), std::string("."), std::string("/"), std::string("\\"),
        std::string("sub/"), std::string("sub/.."), deep})
    EXPECT_NE(problemOf(name), "") << name.substr(0, 40);
}

TEST_F(TextureFinderOf, aFolderIsListedOnceForAllImages) {
  for (int i = 0; i < 200; ++i) write(models_ / "maps" / (std::to_string(i) + ".png"));
  TextureFinder finder(models_ / "a.ply");
  EXPECT_EQ(finder.find("7.png").problem, "");
  write(models_ / "maps" / "new.png");
  EXPECT_NE(finder.find("new.png").problem, "") << "the list is older";
  EXPECT_EQ(finder.find("199.png").problem, "");
}

}  // namespace
}  // namespace lode
