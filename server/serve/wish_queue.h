#pragma once

#include <chrono>
#include <cstdint>
#include <memory_resource>
#include <set>
#include <unordered_map>

#include "proto/messages.h"

namespace lode::serve {

struct OpenedModel;

/// What an open wish is taken to cost in memory.
constexpr uint64_t kWishBytes = 128;

/// Where a wish stands in the queue: by class, then higher priority, then number.
struct Rank {
  proto::WishClass wish_class = proto::WishClass::kVisible;
  float priority_px = 0;
  uint32_t wish = 0;
  bool operator<(const Rank& other) const noexcept;
};

struct OpenWish {
  Rank rank;
  uint32_t handle = 0;
  const OpenedModel* opened = nullptr;
  uint32_t blob = 0;
  uint32_t sent_bytes = 0;
  uint32_t call = 0;
  bool parked = false;  ///< waits for the disk, and is passed by
  uint64_t serial = 0;  ///< tells it from an earlier wish of the same number
  std::chrono::steady_clock::time_point asked;
  std::chrono::steady_clock::duration held_before{};  ///< by the client, when it was asked
};

/// The open wishes of a session, and which of them is next. Not thread safe.
class WishQueue {
 public:
  explicit WishQueue(std::pmr::memory_resource* memory) : wishes_(memory), queue_(memory) {}

  size_t size() const noexcept { return wishes_.size(); }
  bool empty() const noexcept { return wishes_.empty(); }
  OpenWish* find(uint32_t wish);
  /// The most urgent that is not parked, or null.
  OpenWish* first();

  void add(const OpenWish& wish);
  void reprioritise(OpenWish& wish, proto::WishClass wish_class, float priority_px);
  void park(OpenWish& wish);
  void unpark(OpenWish& wish);
  void end(OpenWish& wish);
  void clear();

  /// Ends the wishes of a handle. @param ended  called with each, in the order of their numbers.
  template <typename Ended>
  void endAll(uint32_t handle, Ended ended) {
    std::pmr::set<uint32_t> numbers(queue_.get_allocator().resource());
    for (const auto& [number, wish] : wishes_)
      if (wish.handle == handle) numbers.insert(number);
    for (const uint32_t number : numbers) {
      ended(wishes_.at(number));
      end(wishes_.at(number));
    }
  }

 private:
  std::pmr::unordered_map<uint32_t, OpenWish> wishes_;
  std::pmr::set<Rank> queue_;
};

}  // namespace lode::serve
