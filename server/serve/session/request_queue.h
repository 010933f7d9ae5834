#pragma once

#include <chrono>
#include <cstdint>
#include <memory_resource>
#include <set>
#include <unordered_map>

#include "proto/messages.h"

namespace lode::serve {

struct OpenedModel;

/// What an open request is taken to cost in memory.
constexpr uint64_t kRequestBytes = 128;

/// Where a request stands in the queue: by class, then higher priority, then number.
struct Rank {
  proto::RequestClass request_class = proto::RequestClass::kVisible;
  float priority_px = 0;
  uint32_t request = 0;
  bool operator<(const Rank& other) const noexcept;
};

struct OpenRequest {
  Rank rank;
  uint32_t handle = 0;
  const OpenedModel* opened = nullptr;
  uint32_t blob = 0;
  uint32_t sent_bytes = 0;
  uint32_t call = 0;
  bool parked = false;  ///< waits for the disk, and is passed by
  uint64_t serial = 0;  ///< tells it from an earlier request of the same number
  std::chrono::steady_clock::time_point asked;
  std::chrono::steady_clock::duration held_before{};  ///< by the client, when it was asked
};

/// The open requests of a session, and which of them is next. Not thread safe.
class RequestQueue {
 public:
  explicit RequestQueue(std::pmr::memory_resource* memory) : requests_(memory), queue_(memory) {}

  size_t size() const noexcept { return requests_.size(); }
  bool empty() const noexcept { return requests_.empty(); }
  OpenRequest* find(uint32_t request);
  /// The most urgent that is not parked, or null.
  OpenRequest* first();

  void add(const OpenRequest& request);
  void reprioritise(OpenRequest& request, proto::RequestClass request_class, float priority_px);
  void park(OpenRequest& request);
  void unpark(OpenRequest& request);
  void end(OpenRequest& request);
  void clear();

  /// Ends the requests of a handle. @param ended  called with each, in the order of their numbers.
  template <typename Ended>
  void endAll(uint32_t handle, Ended ended) {
    std::pmr::set<uint32_t> numbers(queue_.get_allocator().resource());
    for (const auto& [number, request] : requests_)
      if (request.handle == handle) numbers.insert(number);
    for (const uint32_t number : numbers) {
      ended(requests_.at(number));
      end(requests_.at(number));
    }
  }

 private:
  std::pmr::unordered_map<uint32_t, OpenRequest> requests_;
  std::pmr::set<Rank> queue_;
};

}  // namespace lode::serve
