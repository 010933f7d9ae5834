#include "common/bounded_queue.h"

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(BoundedQueue, givesItemsBackInOrder) {
  BoundedQueue<int> queue(3);
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(queue.push(i));
  for (int i = 1; i <= 3; ++i) EXPECT_EQ(queue.pop(), i);
}

TEST(BoundedQueue, refusesMoreThanItsCapacityAndLeavesTheItem) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  auto first = std::make_unique<int>(1), second = std::make_unique<int>(2);
  EXPECT_TRUE(queue.tryPush(first));
  EXPECT_FALSE(queue.tryPush(second));
  EXPECT_NE(second, nullptr);
}

TEST(BoundedQueue, tryPopOfAnEmptyQueueGivesNothing) {
  EXPECT_EQ(BoundedQueue<int>(1).tryPop(), std::nullopt);
}

TEST(BoundedQueue, givesItsRemainingItemsAfterClosing) {
  BoundedQueue<int> queue(2);
  queue.push(1);
  queue.close();
  int item = 2;
  EXPECT_FALSE(queue.push(2));
  EXPECT_FALSE(queue.tryPush(item));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, closeWakesAConsumerThatWaits) {
  BoundedQueue<int> queue(1);
  std::thread consumer([&] { EXPECT_EQ(queue.pop(), std::nullopt); });
  queue.close();
  consumer.join();
}

TEST(BoundedQueue, closeWakesAProducerThatWaits) {
  BoundedQueue<int> queue(1);
  queue.push(1);
  std::thread producer([&] { EXPECT_FALSE(queue.push(2)); });
  queue.close();
  producer.join();
}

TEST(BoundedQueue, losesAndRepeatsNothingBetweenManyThreads) {
  constexpr int kEach = 5000, kThreads = 3;
  BoundedQueue<int> queue(4);
  std::vector<std::atomic<int>> seen(kEach * kThreads);
  std::vector<std::thread> producers, consumers;
  for (int t = 0; t < kThreads; ++t) {
    producers.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i) queue.push(t * kEach + i);
    });
    consumers.emplace_back([&] {
      while (const auto item = queue.pop()) ++seen[static_cast<size_t>(*item)];
    });
  }
  for (auto& producer : producers) producer.join();
  queue.close();
  for (auto& consumer : consumers) consumer.join();
  for (const auto& count : seen) ASSERT_EQ(count, 1);
}

}  // namespace
}  // namespace lode
