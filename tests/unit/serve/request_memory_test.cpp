#include "server/serve/session/request_memory.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "server/serve/session/request_queue.h"

namespace lode::serve {
namespace {

/// Counts what was taken from it and not given back.
class CountedSystem : public std::pmr::memory_resource {
 public:
  size_t bytes = 0, asked = 0;

 private:
  void* do_allocate(size_t more, size_t alignment) override {
    ++asked;
    bytes += more;
    return std::pmr::new_delete_resource()->allocate(more, alignment);
  }
  void do_deallocate(void* memory, size_t less, size_t alignment) override {
    bytes -= less;
    std::pmr::new_delete_resource()->deallocate(memory, less, alignment);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }
};

void add(RequestQueue& queue, uint32_t number) {
  OpenRequest request;
  request.rank.request = number;
  queue.add(request);
}

void addAndEnd(RequestQueue& queue, uint32_t count) {
  for (uint32_t request = 1; request <= count; ++request) add(queue, request);
  for (uint32_t request = 1; request <= count; ++request) queue.end(*queue.find(request));
}

TEST(RequestMemory, keepsWhatEndedRequestsHadForTheNext) {
  CountedSystem system;
  RequestMemory memory(&system);
  RequestQueue queue(&memory);
  addAndEnd(queue, 1000);
  const size_t before = system.asked;
  addAndEnd(queue, 1000);
  EXPECT_EQ(system.asked, before);
}

TEST(RequestMemory, givesBackWhatAFloodOfRequestsHadBeyondItsBound) {
  CountedSystem system;
  RequestMemory memory(&system);
  {
    std::vector<RequestQueue> queues;
    for (int i = 0; i < 10; ++i) queues.emplace_back(&memory);
    for (RequestQueue& queue : queues)
      for (uint32_t request = 1; request <= 5000; ++request) add(queue, request);
    EXPECT_GT(system.bytes, 4 * RequestMemory::kMaxKeptBytes);
  }
  EXPECT_LE(system.bytes, RequestMemory::kMaxKeptBytes);
}

TEST(RequestMemory, takesLittleMoreThanWhatRequestsAreCountedWith) {
  CountedSystem system;
  RequestMemory memory(&system);
  RequestQueue queue(&memory);
  constexpr uint32_t kMany = 13'000;  // just before the table of numbers would grow
  for (uint32_t request = 1; request <= kMany; ++request) add(queue, request);
  EXPECT_LE(system.bytes, kMany * kRequestBytes * 5 / 4);
}

TEST(RequestMemory, holdsWhatWasWrittenWhicheverPiecesComeAndGo) {
  CountedSystem system;
  RequestMemory memory(&system);
  std::mt19937 random(1);
  std::vector<std::span<unsigned char>> pieces;
  const auto giveBack = [&](size_t which) {
    const auto piece = pieces[which];
    for (const unsigned char byte : piece) ASSERT_EQ(byte, static_cast<unsigned char>(piece.size()));
    memory.deallocate(piece.data(), piece.size(), 8);
    pieces[which] = pieces.back();
    pieces.pop_back();
  };
  for (int round = 0; round < 50'000; ++round) {
    if (random() % 1000 < (round % 10'000 < 5'000 ? 600u : 400u) || pieces.empty()) {
      const size_t bytes = 1 + random() % 200;
      pieces.emplace_back(static_cast<unsigned char*>(memory.allocate(bytes, 8)), bytes);
      std::ranges::fill(pieces.back(), static_cast<unsigned char>(bytes));
    } else {
      giveBack(random() % pieces.size());
    }
  }
  while (!pieces.empty()) giveBack(0);
  EXPECT_LE(system.bytes, RequestMemory::kMaxKeptBytes);
}

TEST(RequestMemory, givesAllBackAtItsEnd) {
  CountedSystem system;
  {
    RequestMemory memory(&system);
    RequestQueue queue(&memory);
    addAndEnd(queue, 100);
  }
  EXPECT_EQ(system.bytes, 0u);
}

TEST(RequestMemory, isAlignedForWhateverAsks) {
  RequestMemory memory;
  for (const size_t alignment : {1u, 8u, 16u, 64u})
    for (const size_t bytes : {1u, 17u, 256u, 257u, 5000u}) {
      void* const piece = memory.allocate(bytes, alignment);
      EXPECT_EQ(reinterpret_cast<uintptr_t>(piece) % alignment, 0u);
      memory.deallocate(piece, bytes, alignment);
    }
}

}  // namespace
}  // namespace lode::serve
