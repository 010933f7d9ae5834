#include "server/ingest/partition/in_order.h"

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(InOrder, handsResultsOnAsThePiecesCameThoughALaterOneEndsSooner) {
  std::latch second_done(1);
  std::vector<int> results;
  InOrder<int> pieces(2, [&](int&& result) { results.push_back(result); });
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

TEST(InOrder, hasNoMoreUnderWayThanItMay) {
  std::atomic<int> under_way = 0, most = 0;
  InOrder<int> pieces(2, [&](int&&) { --under_way; });
  for (int i = 0; i < 50; ++i) {
    pieces.push([&] {
      const int now = ++under_way;
      int before = most;
      while (before < now && !most.compare_exchange_weak(before, now)) continue;
      return 0;
    });
  }
  pieces.finish();
  EXPECT_LE(most, 3);
  EXPECT_EQ(under_way, 0);
}

TEST(InOrder, worksOnTheCallersThreadWhereNoneMayBeUnderWay) {
  std::thread::id where;
  bool is_handed_on = false;
  InOrder<int> pieces(0, [&](int&&) { is_handed_on = true; });
  pieces.push([&] {
    where = std::this_thread::get_id();
    return 0;
  });
  EXPECT_EQ(where, std::this_thread::get_id());
  EXPECT_TRUE(is_handed_on);
}

TEST(InOrder, doesAPieceItselfWhenAsManyAreUnderWayAsMayBe) {
  std::latch second_begun(1);
  std::thread::id where;
  std::vector<int> results;
  InOrder<int> pieces(1, [&](int&& result) { results.push_back(result); });
  pieces.push([&] {
    second_begun.wait();
    return 1;
  });
  pieces.push([&] {
    where = std::this_thread::get_id();
    second_begun.count_down();
    return 2;
  });
  EXPECT_EQ(where, std::this_thread::get_id());
  EXPECT_EQ(results, (std::vector<int>{1, 2}));
}

std::atomic<int> threads_made = 0;
struct ThreadMark {
  ThreadMark() { ++threads_made; }
  int one = 1;
};

TEST(InOrder, makesNoMoreThreadsThanMayBeUnderWay) {
  threads_made = 0;
  InOrder<int> pieces(2, [](int&&) {});
  for (int i = 0; i < 200; ++i)
    pieces.push([] {
      thread_local ThreadMark mark;
      return mark.one;
    });
  pieces.finish();
  EXPECT_LE(threads_made, 3) << "two of its own, and the caller's";
}

TEST(InOrder, waitsForPiecesUnderWayWhenItGoes) {
  std::atomic<int> done = 0;
  {
    InOrder<int> pieces(3, [](int&&) {});
    for (int i = 0; i < 3; ++i) pieces.push([&] { return ++done; });
  }
  EXPECT_EQ(done, 3);
}

TEST(InOrder, throwsWhatAPieceHasThrown) {
  InOrder<int> pieces(2, [](int&&) {});
  pieces.push([]() -> int { throw std::runtime_error("of a piece"); });
  EXPECT_THROW(pieces.finish(), std::runtime_error);
}

}  // namespace
}  // namespace lode::ingest
