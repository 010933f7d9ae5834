// Tests of folders that other users can write: the programs follow no links of other users and give them no
// access.

#include "tests/support/strangers.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "programs.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Strangers : public testing::Test {
 protected:
  Strangers() { EXPECT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000", "-o", ply_}).status, 0); }

  /// Runs fetch without HOME and XDG_CACHE_HOME, as cron and units do.
  Outcome fetchWithoutHome() const {
    return lodestream({"fetch", ply_, "--pixels", "4"},
                      {"HOME=", "XDG_CACHE_HOME=", "TMPDIR=" + sticky_.string()});
  }

  /// Builds the store of a triangle with a texture.
  fs::path buildTextured() const {
    writeBytes(folder_ / "t.ply",
               "ply\nformat ascii 1.0\ncomment TextureFile red.png\nelement vertex 3\nproperty float x\n"
               "property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n"
               "property list uchar int vertex_indices\nend_header\n"
               "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n3 0 1 2\n");
    writeBytes(folder_ / "red.png", kRed);
    EXPECT_EQ(lodestreamd({"build", folder_ / "t.ply", "-o", folder_ / "t.lode", "--quiet"}).status, 0);
    return folder_ / "t.lode";
  }

  /// PNG of one red pixel.
  static constexpr std::string_view kRed{
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x02\0\0\0\x90wS\xde\0\0\0\x0cIDATx\x9c"
      "c\xf8\xcf\xc0\0\0\x03\x01\x01\0\xc9\xfe\x92\xef\0\0\0\0IEND\xae"
      "B`\x82",
      69};

  const WorkFolder folder_;
  const fs::path ply_ = folder_ / "a.ply", sticky_ = makeStickyFolder(folder_ / "tmp");
  const fs::path fallback_ = sticky_ / ("lodestream-" + std::to_string(::getuid()));
};

TEST_F(Strangers, cannotRedirectTheFallbackCacheByALink) {
  fs::create_directory(folder_ / "mine");
  std::ofstream(folder_ / "mine" / "thesis") << "precious";
  fs::create_directory_symlink(folder_ / "mine", fallback_);
  if (!giveToStranger(fallback_)) GTEST_SKIP() << "needs root";
  expectFailure(fetchWithoutHome(), {"is not a folder that only you can write to", "XDG_CACHE_HOME"});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "mine"), {}), 1);
}

TEST_F(Strangers, cannotProvideTheFallbackCache) {
  fs::create_directory(fallback_);
  if (!giveToStranger(fallback_)) GTEST_SKIP() << "needs root";
  expectFailure(fetchWithoutHome(), {"is not a folder that only you can write to"});
  EXPECT_TRUE(fs::is_empty(fallback_));
}

TEST_F(Strangers, cannotReadCachedStores) {
  const Outcome fetched = fetchWithoutHome();
  EXPECT_EQ(fetched.status, 0) << fetched.err;
  EXPECT_EQ(modeOf(fallback_), 0700u);
  size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fallback_)) {
    EXPECT_EQ(modeOf(entry.path()), entry.is_directory() ? 0700u : 0600u) << entry.path();
    files += entry.is_regular_file();
  }
  EXPECT_GE(files, 2u);
}

TEST_F(Strangers, cannotRedirectTheRemovalOfStoresByALink) {
  ASSERT_EQ(fetchWithoutHome().status, 0);
  const fs::path of_source = fs::directory_iterator(fallback_ / "stores")->path();
  fs::remove_all(of_source);
  fs::create_directory(folder_ / "mine");
  std::ofstream(folder_ / "mine" / "thesis") << "precious";
  fs::create_directory_symlink(folder_ / "mine", of_source);
  expectFailure(fetchWithoutHome(), {"is not a folder that only you can write to"});
  EXPECT_TRUE(fs::exists(folder_ / "mine" / "thesis"));
}

TEST_F(Strangers, cannotRedirectOutputsByTheirLinks) {
  std::ofstream(folder_ / "victim") << "precious";
  for (const char* name : {"out.ply", "out.lode", "out.png", "out.json"}) {
    fs::create_symlink(folder_ / "victim", sticky_ / name);
    if (!giveToStranger(sticky_ / name)) GTEST_SKIP() << "needs root";
  }
  expectFailure(lodestream({"fetch", ply_, "--pixels", "4", "-o", sticky_ / "out.ply"}), {"another user"});
  expectFailure(lodestream({"replay", ply_, "--record", sticky_ / "out.json"}), {"another user"});
  expectFailure(lodestreamd({"build", ply_, "-o", sticky_ / "out.lode", "--quiet"}), {"another user"});
  expectFailure(lodestreamd({"sample", "gyroid", "--triangles", "5000", "-o", sticky_ / "out.ply"}),
                {"another user"});
  EXPECT_EQ(readBytes(folder_ / "victim"), "precious");
}

TEST_F(Strangers, cannotReadFilesOfAModelBehindAToken) {
  ASSERT_EQ(lodestreamd({"build", ply_, "-o", folder_ / "a.lode", "--quiet"}).status, 0);
  writeBytes(folder_ / "tokens", "open-sesame never *\n");
  fs::permissions(folder_ / "tokens", fs::perms(0600));
  const RunningServer server({folder_ / "a.lode"}, {"--token-file", folder_ / "tokens"});
  const std::vector<std::string> with_token{"LODESTREAM_TOKEN=open-sesame",
                                            "XDG_CACHE_HOME=" + (folder_ / "cache").string()};
  const Outcome fetched =
      lodestream({"fetch", server.url("a"), "--pixels", "4", "-o", folder_ / "cut.ply"}, with_token);
  EXPECT_EQ(fetched.status, 0) << fetched.err;
  EXPECT_EQ(modeOf(folder_ / "cut.ply"), 0600u);
  EXPECT_EQ(modeOf(folder_ / "cache"), 0700u);
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
    EXPECT_EQ(modeOf(entry.path()), entry.is_directory() ? 0700u : 0600u) << entry.path();
  ASSERT_EQ(lodestream({"fetch", ply_, "--pixels", "4", "-o", folder_ / "open.ply"}, with_token).status, 0);
  EXPECT_EQ(modeOf(folder_ / "open.ply"), 0644u) << "a local file is not protected by the token";
}

TEST_F(Strangers, causeAWarningIfTheyCanReadTheTokenFile) {
  writeBytes(folder_ / "token", "open-sesame\n");
  fs::permissions(folder_ / "token", fs::perms(0644));
  const Outcome open = lodestream({"fetch", ply_, "--pixels", "4", "--token-file", folder_ / "token"});
  EXPECT_EQ(open.status, 0) << open.err;
  EXPECT_NE(open.err.find("warning: " + (folder_ / "token").string()), std::string::npos) << open.err;
  fs::permissions(folder_ / "token", fs::perms(0600));
  const Outcome closed = lodestream({"fetch", ply_, "--pixels", "4", "--token-file", folder_ / "token"});
  EXPECT_EQ(closed.err, "");
}

TEST_F(Strangers, sideFilesAreListedAndReplaceOnlyOwnRegularFiles) {
  const fs::path store = buildTextured(), out = folder_ / "cut.obj";
  const std::vector<std::string> beside{folder_ / "cut_red.png", folder_ / "cut.mtl"};
  for (int times = 0; times < 2; ++times) {  // the second time replaces the files
    const Outcome exported = lodestreamd({"export", store, "--error", "0", "-o", out, "--json"});
    ASSERT_EQ(exported.status, 0) << exported.err;
    EXPECT_EQ(Json::parse(exported.out)["files_beside"], Json(beside));
    const Outcome fetched = lodestream({"fetch", store, "-o", out, "--json"});
    ASSERT_EQ(fetched.status, 0) << fetched.err;
    EXPECT_EQ(Json::parse(fetched.out)["files_beside"], Json(beside));
  }
  for (const std::string& name : beside) {
    EXPECT_NE(lodestreamd({"export", store, "--error", "0", "-o", out}).out.find(name), std::string::npos);
    EXPECT_NE(lodestream({"fetch", store, "-o", out}).out.find(name), std::string::npos);
    fs::remove(name);
    writeBytes(folder_ / "victim", "precious");
    fs::create_symlink("victim", name);
    expectFailure(lodestreamd({"export", store, "--error", "0", "-o", out}), {name, "not a regular file"});
    expectFailure(lodestream({"fetch", store, "-o", out}), {name, "not a regular file"});
    EXPECT_EQ(readBytes(folder_ / "victim"), "precious");
    fs::remove(name);
  }
}

TEST_F(Strangers, pipesAndDevicesAreRefusedAsInputsAtOnce) {
  for (const char* name : {"pipe", "pipe.json"}) ASSERT_EQ(mkfifo((folder_ / name).c_str(), 0600), 0);
  const std::string pipe = folder_ / "pipe";
  expectFailure(lodestream({"fetch", pipe}), {pipe, "pipe"});
  expectFailure(lodestream({"fetch", "/dev/zero"}), {"/dev/zero", "device"});
  expectFailure(lodestream({"fetch", ply_, "--camera", pipe}), {pipe, "pipe"});
  expectFailure(lodestream({"loadtest", ply_, "--clients", "1", "--seconds", "1", "--trace", pipe}),
                {pipe, "pipe"});
  expectFailure(lodestreamd({"info", pipe}), {pipe, "not a regular file"});
  expectFailure(lodestreamd({"serve", pipe}), {pipe, "not a regular file"});
  expectFailure(lodestreamd({"build", pipe, "-o", folder_ / "b.lode"}), {pipe, "not a regular file"});
}

}  // namespace
}  // namespace lode::test
