#include "server/page/page_files.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/bytes.h"

namespace lode::page {

/// Returns the files of tests/unit/page/sample.
std::span<const PageFile> sampleFiles() noexcept;

namespace {

std::string textOf(const PageFile& file) {
  return {reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()};
}

TEST(PageFiles, areTheFilesOfAFolder) {
  std::map<std::string, std::string> expected, found;
  for (const auto& entry : std::filesystem::directory_iterator(LODE_SAMPLE_FOLDER))
    expected[entry.path().filename()] = test::readBytes(entry.path());
  for (const PageFile& file : sampleFiles()) found[std::string(file.name)] = textOf(file);
  EXPECT_EQ(expected.size(), 3u);
  EXPECT_EQ(found, expected);
}

TEST(PageFiles, haveHashesOfTheirBytes) {
  std::set<std::string_view> hashes;
  for (const PageFile& file : sampleFiles()) {
    EXPECT_EQ(file.hash.size(), 32u) << file.name;
    EXPECT_TRUE(hashes.insert(file.hash).second) << file.name;
  }
  EXPECT_EQ(findFile(sampleFiles(), "empty.js")->hash, "e3b0c44298fc1c149afbf4c8996fb924");  // SHA-256 of ""
}

TEST(PageFiles, areFoundByName) {
  ASSERT_NE(findFile(sampleFiles(), "a.txt"), nullptr);
  EXPECT_EQ(textOf(*findFile(sampleFiles(), "a.txt")), "hello\n");
  for (const char* const name : {"", "A.txt", "a.txt/", "../sample/a.txt", "a"})
    EXPECT_EQ(findFile(sampleFiles(), name), nullptr) << name;
}

TEST(PageFiles, OfTheProgramHaveAnIndexUnlessThereAreNone) {
  EXPECT_EQ(builtInPage().empty(), findFile(builtInPage(), "index.html") == nullptr);
}

}  // namespace
}  // namespace lode::page
