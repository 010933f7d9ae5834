#include "client/app/window/model_choices.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

TEST(KeptChoices, areThoseOfTheSameFileByAnyPath) {
  const test::WorkFolder work;
  const std::filesystem::path folder = work.path() / "cache" / "lodestream", model = work.path() / "a.ply";
  std::filesystem::create_directories(work.path() / "b");
  const ModelChoices choices{"-z", "mm"};
  KeptChoices(folder, model.string()).keep(choices);
  EXPECT_EQ(KeptChoices(folder, (work.path() / "b" / ".." / "a.ply").string()).read(), choices);
  EXPECT_EQ(KeptChoices(folder, (work.path() / "b.ply").string()).read(), ModelChoices());
  EXPECT_EQ(KeptChoices(folder, "lode://host/a").read(), ModelChoices());
}

TEST(KeptChoices, areIgnoredIfTheFileHasOtherContents) {
  const test::WorkFolder work;
  const KeptChoices kept(work.path(), "lode://host/a");
  kept.keep({"y", "cm"});
  const auto file = std::filesystem::directory_iterator(work.path() / "choices")->path();
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[1]"), std::string(R"({"up": 1, "unit": {}})"),
        std::string(R"({"up": "w", "unit": "parsec"})"),
        R"({"up": "z", "x": ")" + std::string(300, 'a') + "\"}"}) {
    std::ofstream(file) << text;
    EXPECT_EQ(kept.read(), ModelChoices()) << text;
  }
}

TEST(KeptChoices, tolerateAnUnwritableFolder) {
  const KeptChoices kept("/proc/lodestream", "a.ply");
  kept.keep({"z", ""});
  EXPECT_EQ(kept.read(), ModelChoices());
}

}  // namespace
}  // namespace lode::app
