// Tests that an embedding program gets an error and continues if no thread can be created.

#include <climits>
#include <string>

#include <gtest/gtest.h>

#include "client/embed/lodestream.h"
#include "tests/support/scarce_threads.h"

namespace lode::embed {
namespace {

using test::threads_left;

constexpr const char* kNoServer = "lode://127.0.0.1:1/model";

/// Returns the last error of a stream with three decode threads if only `threads` threads can be started.
std::string saidWith(int threads) {
  lodestream_options options{};
  options.decode_threads = 3;
  threads_left = threads;
  lodestream_stream* const stream = lodestream_open(kNoServer, &options);
  lodestream_status status{};
  while (stream != nullptr && !status.has_ended && lodestream_step(stream, 1000, &status) != 0) continue;
  const std::string said = lodestream_last_error();
  threads_left = INT_MAX;
  lodestream_close(stream);
  return said;
}

TEST(Threads, failWithPurposeAndAdviceIfUnavailable) {
  for (int threads = 0; threads < 5; ++threads) {
    const std::string said = saidWith(threads);
    EXPECT_NE(said.find("cannot start a thread"), std::string::npos) << threads << ": " << said;
    EXPECT_NE(said.find("ulimit"), std::string::npos) << threads << ": " << said;
  }
  EXPECT_NE(saidWith(2).find("decode"), std::string::npos);
  EXPECT_NE(saidWith(5).find("cannot connect"), std::string::npos);
}

TEST(Threads, refuseMoreDecodeThreadsThanTheLimit) {
  lodestream_options options{};
  options.decode_threads = 100'000;
  EXPECT_EQ(lodestream_open(kNoServer, &options), nullptr);
  EXPECT_STREQ(lodestream_last_error(),
               "decode_threads is 100000, but at most 256 are allowed; 0 selects the default");
}

}  // namespace
}  // namespace lode::embed
