// A system that gives no more threads: the program that embeds the library goes on, and is told.

#include <atomic>
#include <cerrno>
#include <climits>
#include <string>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include "client/embed/lodestream.h"

namespace lode::embed {
namespace {

/// That the system still gives this program.
std::atomic<int> threads_left{INT_MAX};

}  // namespace
}  // namespace lode::embed

/// This program's own: the system's, but for threads_left.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  if (lode::embed::threads_left <= 0) return EAGAIN;
  --lode::embed::threads_left;
  static const auto system = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return system(thread, attributes, start, argument);
}

namespace lode::embed {
namespace {

constexpr const char* kNoServer = "lode://127.0.0.1:1/model";

/// What a stream with three threads that decode says in the end, where so many threads can be had.
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

TEST(Threads, thatCannotBeHadAreAnErrorThatSaysWhatForAndWhatToDo) {
  for (int threads = 0; threads < 5; ++threads) {
    const std::string said = saidWith(threads);
    EXPECT_NE(said.find("gives no thread"), std::string::npos) << threads << ": " << said;
    EXPECT_NE(said.find("ulimit"), std::string::npos) << threads << ": " << said;
  }
  EXPECT_NE(saidWith(2).find("decode"), std::string::npos);
  EXPECT_NE(saidWith(5).find("cannot connect"), std::string::npos);
}

TEST(Threads, thatDecodeHaveALimitThatTheErrorNames) {
  lodestream_options options{};
  options.decode_threads = 100'000;
  EXPECT_EQ(lodestream_open(kNoServer, &options), nullptr);
  EXPECT_STREQ(lodestream_last_error(), "decode_threads is 100000, and may be 256 at most; 0 is the default");
}

}  // namespace
}  // namespace lode::embed
