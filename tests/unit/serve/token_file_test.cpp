#include "server/serve/session/token_file.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;

constexpr auto kNow = sys_days(std::chrono::year(2026) / 11 / 22) + 3h;

std::string tokenRefusal(const std::string& text, ErrorCode code = ErrorCode::kUsage) {
  try {
    TokenFile::parse(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "accepted";
}

void expectRefused(const std::string& text, const std::string& why) {
  EXPECT_NE(tokenRefusal(text).find(why), std::string::npos) << tokenRefusal(text);
}

TEST(TokenFile, grantsTheModelsInATokensLine) {
  const TokenFile file = TokenFile::parse(
      "# for the museum\n\nm1 never bunny \"old town\" \"a \\\"b\\\"\"\r\n   m2\tnever\t*\n");
  ASSERT_EQ(file.size(), 2u);
  const TokenGrant* some = file.find("m1", kNow);
  ASSERT_NE(some, nullptr);
  for (const char* name : {"bunny", "old town", "a \"b\""}) EXPECT_TRUE(some->allows(name)) << name;
  for (const char* name : {"", "bunn", "bunny2", "old", "*"}) EXPECT_FALSE(some->allows(name)) << name;
  const TokenGrant* all = file.find("m2", kNow);
  ASSERT_NE(all, nullptr);
  EXPECT_TRUE(all->allows("anything"));
}

TEST(TokenFile, acceptsOnlyItsTokens) {
  const TokenFile file = TokenFile::parse("secret never *\n");
  for (const char* token : {"", "s", "secre", "secret ", "Secret", "secrets", "never", "#"})
    EXPECT_EQ(file.find(token, kNow), nullptr) << token;
  EXPECT_NE(file.find("secret", kNow), nullptr);
}

TEST(TokenFile, ignoresComments) {
  const TokenFile file =
      TokenFile::parse("  # of the museum\na never bunny # not gyroid\nb never \"#1\" x#y\n");
  EXPECT_EQ(file.modelsNamed(), (std::vector<std::string>{"#1", "bunny", "x#y"}));
}

TEST(TokenFile, readsTheFirstTokenAfterAByteOrderMark) {
  EXPECT_NE(TokenFile::parse("\xef\xbb\xbfsecret never *\n").find("secret", kNow), nullptr);
}

TEST(TokenFile, isSearchedToItsEndForEveryToken) {
  std::string text;
  for (size_t i = 1000; i < 1000 + kMaxTokens; ++i) text += "t" + std::to_string(i) + " never *\n";
  const TokenFile file = TokenFile::parse(text);
  const auto shortest = [&](std::string_view token) {
    auto least = std::chrono::steady_clock::duration::max();
    for (int i = 0; i < 200; ++i) {
      const auto start = std::chrono::steady_clock::now();
      file.find(token, kNow);
      least = std::min(least, std::chrono::steady_clock::now() - start);
    }
    return least;
  };
  const auto none = shortest("none!");
  for (const char* token : {"t1000", "t3000", "t5095"}) {
    EXPECT_LT(shortest(token), none * 3 / 2) << token;
    EXPECT_GT(shortest(token), none * 2 / 3) << token;
  }
}

TEST(TokenFile, takesATokenUntilItExpires) {
  const TokenFile file = TokenFile::parse("t 2026-11-22T03:00:01Z *\nleap 2028-02-29T23:59:59Z *\n");
  EXPECT_NE(file.find("t", kNow), nullptr);
  EXPECT_EQ(file.find("t", kNow + 1s), nullptr);
  EXPECT_NE(file.find("leap", sys_days(std::chrono::year(2028) / 2 / 29)), nullptr);
}

TEST(TokenFile, takesATokenThatExpiresInAFarFuture) {
  for (const char* time : {"2262-04-12T00:00:00Z", "4054-01-27T00:00:00Z", "9999-12-31T23:59:59Z"})
    EXPECT_NE(TokenFile::parse(std::string("secret ") + time + " *").find("secret", kNow), nullptr) << time;
}

TEST(TokenFile, isRefusedWithTheLineOfAnError) {
  expectRefused("a never *\nb\n", "line 2 of the token file: it names no model");
  expectRefused("a never\n", "line 1 of the token file: it names no model");
  expectRefused("a tomorrow *\n", "line 1 of the token file: the second word");
  expectRefused("# x\n\na never \"b\n", "line 3 of the token file: a quote");
  expectRefused("a never * b\n", "* allows all models and must be the only name");
  expectRefused("a never *\nb never *\na never x\n", "line 3 of the token file: the token is also in line 1");
  expectRefused("a never \x01\n", "a model name is invalid");
  expectRefused("a never " + std::string(256, 'x') + "\n", "a model name is invalid");
  expectRefused(std::string(513, 'x') + " never *\n", "a token is 1 to 512 bytes");
  expectRefused("\"\" never *\n", "a token is 1 to 512 bytes");
}

TEST(TokenFile, isRefusedWithAnInvalidTime) {
  for (const char* time : {"2026-02-29T00:00:00Z", "2026-13-01T00:00:00Z", "2026-01-01T24:00:00Z",
                           "2026-01-01T00:60:00Z", "2026-01-01", "2026-01-01T00:00:00",
                           "2026-01-01t00:00:00Z", "2026-01-01T00:00:00+01", "-026-01-01T00:00:00Z"})
    expectRefused(std::string("a ") + time + " *\n", "neither never nor a time");
}

TEST(TokenFile, isRefusedWithoutAToken) {
  expectRefused("", "holds no token");
  expectRefused("# nothing\n\n", "holds no token");
}

TEST(TokenFile, neverTellsATokenInAnError) {
  for (const char* text : {"hushhush\n", "hushhush x *\n", "hushhush never *\nhushhush never *\n",
                           "hushhush never \"x\n", "\"hushhush never x\n"})
    EXPECT_EQ(tokenRefusal(text).find("hush"), std::string::npos) << tokenRefusal(text);
}

TEST(TokenFile, isRefusedWithMoreTokensThanItsLimit) {
  std::string text;
  for (size_t i = 0; i < kMaxTokens; ++i) text += "t" + std::to_string(i) + " never *\n";
  EXPECT_EQ(TokenFile::parse(text).size(), kMaxTokens);
  EXPECT_NE(tokenRefusal(text + "last never *\n", ErrorCode::kLimit).find("line 4097"), std::string::npos);
}

TEST(TokenFile, isNamedInItsErrors) {
  const test::WorkFolder folder;
  const auto expectNamed = [&](const std::filesystem::path& path) {
    try {
      TokenFile::read(path);
      ADD_FAILURE() << path << " was read";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
    }
  };
  expectNamed(folder / "missing");
  std::ofstream(folder / "wrong") << "a tomorrow *\n";
  expectNamed(folder / "wrong");
}

TEST(TokenFile, isReadFromAFileOfBoundedSize) {
  const test::WorkFolder folder;
  const auto path = folder.path() / "tokens";
  EXPECT_THROW(TokenFile::read(path), Error);
  EXPECT_THROW(TokenFile::read(folder.path()), Error);
  std::ofstream(path) << "t never *\n";
  EXPECT_NE(TokenFile::read(path).find("t", kNow), nullptr);
  std::ofstream(path) << std::string(kMaxTokenFileBytes + 1, '#');
  EXPECT_THROW(TokenFile::read(path), Error);
}

}  // namespace
}  // namespace lode::serve
