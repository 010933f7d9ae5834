#include "server/serve/session/reader_threads.h"

#include <chrono>
#include <climits>
#include <future>

#include <asio/post.hpp>
#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/scarce_threads.h"

namespace lode::serve {
namespace {

TEST(ReaderThreads, failAndEndWhereTheSystemDoesNotGiveAll) {
  for (const int threads : {0, 1, 2, 3}) {
    test::threads_left = threads;
    EXPECT_THROW(ReaderThreads(4), Error) << threads;
  }
  test::threads_left = INT_MAX;
}

TEST(ReaderThreads, waitForTheDiskBesideOneAnother) {
  ReaderThreads readers(4);
  std::promise<void> first_came, last_came;
  bool came_meanwhile = false;
  asio::post(readers.pool(), [&] {
    first_came.set_value();
    came_meanwhile = last_came.get_future().wait_for(std::chrono::seconds(300)) == std::future_status::ready;
  });
  first_came.get_future().wait();
  asio::post(readers.pool(), [&] { last_came.set_value(); });
  readers.join();
  EXPECT_TRUE(came_meanwhile);
}

}  // namespace
}  // namespace lode::serve
