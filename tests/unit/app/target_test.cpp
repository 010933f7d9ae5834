#include "client/app/cli/target.h"

#include <fstream>
#include <functional>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/error.h"
#include "common/limits.h"
#include "proto/limits.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

ErrorCode codeOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::kInternal;
}

TEST(Target, isAModelOfAServer) {
  EXPECT_EQ(std::get<stream::ServedModel>(parseTarget("lode://example.org:81/bunny")),
            (stream::ServedModel{{"example.org", 81}, "bunny"}));
  EXPECT_EQ(std::get<stream::ServedModel>(parseTarget("lode://[::1]/a b.c")),
            (stream::ServedModel{{"::1", proto::kDefaultPort}, "a b.c"}));
  EXPECT_EQ(std::get<stream::ServedModel>(parseTarget("lodes://h:81/a")),
            (stream::ServedModel{{"h", 81}, "a", true}));
  const std::string longest(kMaxModelNameBytes, 'x');
  EXPECT_EQ(std::get<stream::ServedModel>(parseTarget("lode://h/" + longest)).model, longest);
}

TEST(Target, isRefusedIfItIsAUrlOfAnotherScheme) {
  for (const std::string text : {"lode://h", "lode://h/", "lode:///a", "lode://h:0/a", "lode://h/a/b",
                                 "lodes://h", "http://h/a", "://h/a"})
    EXPECT_EQ(codeOf([&] { parseTarget(text); }), ErrorCode::kUsage) << text;
  EXPECT_EQ(codeOf([] { parseTarget("lode://h/" + std::string(kMaxModelNameBytes + 1, 'x')); }),
            ErrorCode::kUsage);
}

class TargetFile : public testing::Test {
 protected:
  std::string write(const char* name, const char* text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  test::WorkFolder folder_;
};

TEST_F(TargetFile, isRefusedAtOnceIfItIsAPipeOrADevice) {
  ASSERT_EQ(mkfifo((folder_ / "pipe.ply").c_str(), 0600), 0);
  for (const fs::path& name : {folder_ / "pipe.ply", fs::path("/dev/zero")})
    EXPECT_EQ(codeOf([&] { parseTarget(name.string()); }), ErrorCode::kInput) << name;
}

TEST_F(TargetFile, isAPlyByItsContentWhateverItsName) {
  const std::string path = write("scan", "ply\nformat ascii 1.0\n");
  EXPECT_EQ(std::get<PlyFile>(parseTarget(path)).path, path);
}

TEST_F(TargetFile, isAPlyByItsNameEvenIfItsContentIsNot) {
  EXPECT_TRUE(std::holds_alternative<PlyFile>(parseTarget(write("a.ply", "x"))));
}

TEST_F(TargetFile, isAStoreOtherwise) {
  const std::string path = write("a.lode", "LODE\r\n");
  EXPECT_EQ(std::get<StoreFile>(parseTarget(path)).path, path);
  EXPECT_TRUE(std::holds_alternative<StoreFile>(parseTarget(write("a", "x"))));
}

TEST_F(TargetFile, isRefusedInOneLineIfItHasAnotherFormat) {
  struct Case {
    const char *name, *text, *words;
  };
  const Case cases[] = {
      {"a.obj", "v 0 0 0\n",
       " is an OBJ, neither a PLY file nor a store; Lodestream reads PLY: convert it ("},
      {"a.ply", "glTF\2", " is a GLB (binary glTF), neither a PLY file nor a store; "},
      {"a.lode", "\x89PNG\r\n\x1a\n", " is a PNG picture, neither a PLY file nor a store; "},
      {"b.ply", "", " is empty; copy or export it again"},
      {"c.ply", "BZh91AY", " is compressed with bzip2; unpack it first: bzip2 -dc "},
  };
  for (const Case& each : cases) {
    const std::string path = write(each.name, each.text);
    try {
      parseTarget(path);
      ADD_FAILURE() << each.name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_TRUE(std::string_view(error.what()).starts_with(path + each.words)) << error.what();
      EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
    }
  }
}

TEST_F(TargetFile, isRefusedIfMissingOrADirectory) {
  EXPECT_EQ(codeOf([&] { parseTarget((folder_ / "none.ply").string()); }), ErrorCode::kIo);
  EXPECT_EQ(codeOf([&] { parseTarget(folder_.path().string()); }), ErrorCode::kInput);
  EXPECT_EQ(codeOf([] { parseTarget(""); }), ErrorCode::kIo);
}

TEST(Target, isTakenForNoCommand) {
  for (const std::string word : {"-", "lode://h/a", "scan.ply", "scans/a", "/a", "./a"})
    EXPECT_TRUE(looksLikeTarget(word)) << word;
  for (const std::string word : {"", "feetch", "build"}) EXPECT_FALSE(looksLikeTarget(word)) << word;
}

TEST(ServerUrl, namesAServerAndNoModel) {
  EXPECT_EQ(parseServerUrl("lode://h:81"), (stream::ServedModel{{"h", 81}, ""}));
  EXPECT_EQ(parseServerUrl("lodes://h/"), (stream::ServedModel{{"h", proto::kDefaultPort}, "", true}));
  for (const std::string text : {"h:81", "lode://", "lode://h/a", "lode://h//", "lodes://h/a", "a.lode"})
    EXPECT_EQ(codeOf([&] { parseServerUrl(text); }), ErrorCode::kUsage) << text;
}

}  // namespace
}  // namespace lode::app
