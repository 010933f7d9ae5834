#include "server/ingest/threads/in_order.h"

#include <atomic>
#include <chrono>
#include <latch>
#include <semaphore>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(InOrder, deliversResultsInOrderEvenIfALaterPieceEndsFirst) {
  std::latch second_done(1);
  std::vector<int> results;
  FixedHelpers helpers(2);
  InOrder<int> pieces(helpers, [&](int&& result) { results.push_back(result); });
  pieces.push([&] {
    second_done.wait();
    return 1;
  });
  pieces.push([&] {
    second_done.count_down();
    return 2;
  });
  pieces.finish();
  EXPECT_EQ(results, (std::vector<int>{1, 2}));
}

TEST(InOrder, runsOneAndQueuesTwoPiecesPerHelper) {
  std::atomic<int> under_way = 0, most = 0;
  FixedHelpers helpers(2);
  InOrder<int> pieces(helpers, [&](int&&) { --under_way; });
  for (int i = 0; i < 50; ++i) {
    most = std::max<int>(most, ++under_way);
    pieces.push([] { return 0; });
  }
  pieces.finish();
  EXPECT_LE(most, 3 * 2 + 1);
  EXPECT_EQ(under_way, 0);
}

TEST(InOrder, worksOnTheCallersThreadWithoutAHelper) {
  std::thread::id where;
  bool is_handed_on = false;
  FixedHelpers none(0);
  InOrder<int> pieces(none, [&](int&&) { is_handed_on = true; });
  pieces.push([&] {
    where = std::this_thread::get_id();
    return 0;
  });
  EXPECT_EQ(where, std::this_thread::get_id());
  EXPECT_TRUE(is_handed_on);
}

TEST(InOrder, runsTheOldestWaitingPieceItselfIfTheQueueIsFull) {
  std::latch first_begun(1), second_begun(1);
  std::thread::id where;
  std::vector<int> results;
  FixedHelpers helpers(1);
  InOrder<int> pieces(helpers, [&](int&& result) { results.push_back(result); });
  pieces.push([&] {
    first_begun.count_down();
    second_begun.wait();
    return 1;
  });
  first_begun.wait();
  pieces.push([&] {
    where = std::this_thread::get_id();
    second_begun.count_down();
    return 2;
  });
  pieces.push([] { return 3; });
  EXPECT_FALSE(second_begun.try_wait());
  pieces.push([] { return 4; });
  EXPECT_EQ(where, std::this_thread::get_id());
  pieces.finish();
  EXPECT_EQ(results, (std::vector<int>{1, 2, 3, 4}));
}

TEST(InOrder, callsAHelperThatBecomesFreeWhilePiecesWait) {
  constexpr auto kPatience = std::chrono::seconds(20);
  std::latch first_begun(1);
  std::binary_semaphore third_begun(0);
  FixedHelpers helpers(1);
  bool was_third_begun = false;
  InOrder<int> pieces(helpers, [](int&&) {});
  std::binary_semaphore second_done(0);
  pieces.push([&] {
    first_begun.count_down();
    second_done.acquire();
    return 1;
  });
  first_begun.wait();
  pieces.push([&] {
    was_third_begun = third_begun.try_acquire_for(kPatience);
    second_done.release();
    return 2;
  });
  pieces.push([&] {
    third_begun.release();
    return 3;
  });
  helpers.release();  // allows one more thread
  pieces.finish();
  EXPECT_TRUE(was_third_begun) << "the caller did the second, and nobody the third beside it";
}

TEST(InOrder, givesItsHelpersBack) {
  FixedHelpers helpers(2);
  {
    InOrder<int> pieces(helpers, [](int&&) {});
    for (int i = 0; i < 20; ++i) pieces.push([] { return 0; });
  }
  EXPECT_TRUE(helpers.take());
  EXPECT_TRUE(helpers.take());
  EXPECT_FALSE(helpers.take());
}

std::atomic<int> threads_made = 0;
struct ThreadMark {
  ThreadMark() { ++threads_made; }
  int one = 1;
};

TEST(InOrder, makesNoMoreThreadsThanThereAreHelpers) {
  threads_made = 0;
  FixedHelpers helpers(2);
  InOrder<int> pieces(helpers, [](int&&) {});
  for (int i = 0; i < 200; ++i)
    pieces.push([] {
      thread_local ThreadMark mark;
      return mark.one;
    });
  pieces.finish();
  EXPECT_LE(threads_made, 3) << "two of its own, and the caller's";
}

TEST(InOrder, waitsForStartedPiecesOnDestruction) {
  std::latch begun(3);
  std::atomic<int> done = 0;
  FixedHelpers helpers(3);
  {
    InOrder<int> pieces(helpers, [](int&&) {});
    for (int i = 0; i < 3; ++i)
      pieces.push([&] {
        begun.arrive_and_wait();
        return ++done;
      });
    begun.wait();
  }
  EXPECT_EQ(done, 3);
}

TEST(InOrder, rethrowsTheExceptionOfAPiece) {
  FixedHelpers helpers(2);
  InOrder<int> pieces(helpers, [](int&&) {});
  EXPECT_THROW(
      {
        pieces.push([]() -> int { throw std::runtime_error("of a piece"); });
        pieces.finish();
      },
      std::runtime_error);
}

}  // namespace
}  // namespace lode::ingest
