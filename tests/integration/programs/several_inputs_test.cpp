// Tests of lodestreamd build with several PLY files, a folder of files, and a list of files.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

using Strings = std::vector<std::string>;

class InputsOfOneModel : public testing::Test {
 protected:
  InputsOfOneModel() {
    std::filesystem::create_directory(folder_ / "scans");
    for (const char* kind : {"asteroid", "gyroid", "terrain"})
      EXPECT_EQ(lodestreamd({"sample", kind, "--triangles", "6000", "-o", scan(kind)}).status, 0);
    writeBytes(folder_ / "scans/notes.txt", "not a scan");
  }

  std::string scan(const std::string& kind) const { return folder_ / ("scans/" + kind + ".ply"); }

  /// Builds a store. @return its bytes.
  std::string bytesOf(Strings words, const std::string& folder) const {
    std::filesystem::create_directory(folder_ / folder);
    const std::string store = folder_ / (folder + "/model.lode");
    words.insert(words.begin(), "build");
    words.insert(words.end(), {"-o", store, "--quiet"});
    const Outcome outcome = lodestreamd(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return readBytes(store);
  }

  WorkFolder folder_;
};

TEST_F(InputsOfOneModel, areGivenByNameByFolderOrByList) {
  const std::string named = bytesOf({scan("asteroid"), scan("gyroid"), scan("terrain")}, "named");
  EXPECT_TRUE(bytesOf({folder_ / "scans"}, "folder") == named) << "in the order of their names";
  writeBytes(folder_ / "list", scan("asteroid") + "\n\n" + scan("gyroid") + "\r\n" + scan("terrain"));
  EXPECT_TRUE(bytesOf({"@" + (folder_ / "list").string()}, "by_list") == named);
  EXPECT_TRUE(bytesOf({scan("asteroid"), "@" + (folder_ / "list").string()}, "more") != named);
}

TEST_F(InputsOfOneModel, areRefusedInOneLine) {
  writeBytes(folder_ / "empty", "\n");
  std::filesystem::create_directory(folder_ / "nothing");
  const std::string output = folder_ / "a.lode";
  expectFailure(lodestreamd({"build", "@" + (folder_ / "missing").string(), "-o", output}),
                {"list of inputs", "missing"});
  for (const Strings& inputs : {Strings{"@" + (folder_ / "empty").string()},
                                {(folder_ / "nothing").string()},
                                {scan("asteroid"), "-"}}) {
    Strings words{"build"};
    words.insert(words.end(), inputs.begin(), inputs.end());
    words.insert(words.end(), {"-o", output});
    const Outcome outcome = lodestreamd(words);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    expectOneLine(outcome.err);
  }
  const Outcome itself = lodestreamd({"build", scan("asteroid"), scan("terrain"), "-o", scan("terrain")});
  EXPECT_EQ(itself.status, 2);
  EXPECT_NE(itself.err.find("is the input itself"), std::string::npos) << itself.err;
}

}  // namespace
}  // namespace lode::test
