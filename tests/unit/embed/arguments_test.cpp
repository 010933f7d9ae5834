// Errors of the C API for invalid arguments.

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "client/embed/lodestream.h"
#include "tests/support/work_folder.h"

namespace lode::embed {
namespace {

constexpr const char* kNobody = "lode://127.0.0.1:1/model";

std::string refusalOf(const char* url, const lodestream_options* options = nullptr) {
  lodestream_stream* const stream = lodestream_open(url, options);
  EXPECT_EQ(stream, nullptr) << url;
  lodestream_close(stream);
  return lodestream_last_error();
}

TEST(Arguments, failAndAreNamedIfNull) {
  lodestream_status status{};
  lodestream_view view{};
  size_t count = 0;
  EXPECT_EQ(lodestream_step(nullptr, 0, &status), 0);
  EXPECT_STREQ(lodestream_last_error(), "the stream is NULL: pass the one from lodestream_open()");
  EXPECT_EQ(lodestream_set_view(nullptr, &view), 0);
  EXPECT_EQ(lodestream_take_cut(nullptr), nullptr);
  EXPECT_EQ(lodestream_cut_part(nullptr, 0, nullptr), 0);
  EXPECT_STREQ(lodestream_last_error(), "the cut is NULL: pass one from lodestream_take_cut()");
  EXPECT_EQ(lodestream_cut_shown(nullptr, &view, nullptr, &count), 0);
  EXPECT_EQ(lodestream_take_mesh(nullptr, 0, nullptr), nullptr);
  EXPECT_EQ(lodestream_cut_tile(nullptr, 0, nullptr), 0);
  EXPECT_EQ(lodestream_cut_texture(nullptr, 0, nullptr), 0);
  EXPECT_EQ(lodestream_describe(nullptr, nullptr), 0);
  lodestream_default_options(nullptr);
}

TEST(Arguments, describeAnEmptyCutIfNull) {
  lodestream_cut_info info{};
  info.parts = 7;
  lodestream_cut_describe(nullptr, &info);
  EXPECT_EQ(info.parts, 0u);
  lodestream_cut_describe(nullptr, nullptr);
}

TEST(Arguments, failIfNullBesideAValidStream) {
  lodestream_stream* const stream = lodestream_open(kNobody, nullptr);
  ASSERT_NE(stream, nullptr) << lodestream_last_error();
  EXPECT_EQ(lodestream_step(stream, 0, nullptr), 0);
  EXPECT_STREQ(lodestream_last_error(), "the status is NULL: pass the address of one");
  EXPECT_EQ(lodestream_set_view(stream, nullptr), 0);
  lodestream_close(stream);
}

TEST(Arguments, failWithTheUrlFormIfTheServerOrModelIsMissing) {
  const std::string form = "write lode://HOST[:PORT]/MODEL, or lodes:// with TLS";
  EXPECT_EQ(refusalOf("a.lode"), "'a.lode' names no server; " + form);
  EXPECT_EQ(refusalOf("lode://localhost"), "'lode://localhost' names no model; " + form);
}

TEST(Arguments, failAtOnceForAnUnusableCacheFolder) {
  const test::WorkFolder folder;
  const std::string file = folder / "file";
  std::ofstream(file) << "not a folder";
  const auto expectRefused = [](const std::string& cache, const std::string& why) {
    lodestream_options options{};
    options.cache_folder = cache.c_str();
    const std::string said = refusalOf(kNobody, &options);
    EXPECT_EQ(said.find(why), 0u) << said;
    EXPECT_NE(said.find("set the option cache_folder to another folder, or to NULL"), std::string::npos)
        << said;
  };
  expectRefused(file, file + ": is not a folder that only you can write to; remove it");
  expectRefused("/proc/nope", "cannot make a folder for the cache in /proc: ");
}

TEST(Arguments, nameTheOptionOfAMissingCaFile) {
  lodestream_options options{};
  options.ca_file = "/none.pem";
  lodestream_stream* const stream = lodestream_open("lodes://127.0.0.1:1/model", &options);
  lodestream_status status{};
  while (stream != nullptr && !status.has_ended) lodestream_step(stream, 1000, &status);
  lodestream_close(stream);
  const std::string said = lodestream_last_error();
  EXPECT_NE(said.find("; set the option ca_file to a PEM file of certificates"), std::string::npos) << said;
}

TEST(Options, giveTheDefaultsThatZerosStandFor) {
  lodestream_options options{};
  lodestream_default_options(&options);
  EXPECT_EQ(options.memory_budget_bytes, 1ull << 30);
  EXPECT_EQ(options.connect_timeout_ms, 20'000u);
  EXPECT_GE(options.triangle_budget, 1u);
  EXPECT_GE(options.decode_threads, 1u);
}

}  // namespace
}  // namespace lode::embed
