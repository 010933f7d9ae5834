#pragma once

#include <chrono>
#include <cstdint>
#include <set>
#include <unordered_map>

#include "proto/messages.h"

namespace lode::serve {

struct OpenedModel;

/// Memory charged for an open request.
constexpr uint64_t kRequestBytes = 128;

/// Position of a request in the queue. Requests are sorted by class, then by descending priority, then by id.
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
  bool parked = false;  ///< the request waits for the disk; first() skips parked requests
  uint64_t serial = 0;  ///< number that distinguishes requests with the same id
  std::chrono::steady_clock::time_point asked;
  /// The session's total time under backpressure when the request arrived.
  std::chrono::steady_clock::duration held_before{};
};

/// The open requests of a session, in the order in which their blobs are sent. Not thread safe.
class RequestQueue {
 public:
  size_t size() const noexcept { return requests_.size(); }
  bool empty() const noexcept { return requests_.empty(); }
  OpenRequest* find(uint32_t request);
  /// Returns the most urgent request that is not parked, or null.
  OpenRequest* first();

  void add(const OpenRequest& request);
  void reprioritise(OpenRequest& request, proto::RequestClass request_class, float priority_px);
  void park(OpenRequest& request);
  void unpark(OpenRequest& request);
  void end(OpenRequest& request);
  void clear();

  /// Ends all requests of a handle. @param ended  function that is called with each request, in the order of
  /// the ids.
  template <typename Ended>
  void endAll(uint32_t handle, Ended ended) {
    std::set<uint32_t> numbers;
    for (const auto& [number, request] : requests_)
      if (request.handle == handle) numbers.insert(number);
    for (const uint32_t number : numbers) {
      ended(requests_.at(number));
      end(requests_.at(number));
    }
  }

 private:
  std::unordered_map<uint32_t, OpenRequest> requests_;  ///< open requests by id
  /// Ranks of the requests that do not wait for the disk.
  std::set<Rank> queue_;
};

}  // namespace lode::serve
