#include "common/start_thread.h"

#include <atomic>
#include <climits>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/scarce_threads.h"

namespace lode {
namespace {

TEST(StartThread, namesThePurposeIfTheSystemHasNoThread) {
  test::threads_left = 0;
  try {
    startThread("to wait", [] {}).join();
    ADD_FAILURE() << "started";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("the system cannot start a thread to wait ("), 0u)
        << error.what();
  }
  test::threads_left = INT_MAX;
}

TEST(StartThreads, startsAsManyThreadsAsTheSystemGives) {
  std::atomic<int> started{0};
  test::threads_left = 3;
  startThreads(8, "to count", [&] { ++started; }).clear();
  EXPECT_EQ(started, 3);
  EXPECT_THROW(startThreads(8, "to count", [&] { ++started; }), Error);
  test::threads_left = INT_MAX;
}

}  // namespace
}  // namespace lode
