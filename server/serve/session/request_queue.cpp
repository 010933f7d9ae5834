#include "server/serve/session/request_queue.h"

#include <tuple>

namespace lode::serve {

bool Rank::operator<(const Rank& other) const noexcept {
  return std::tuple(request_class, -priority_px, request) <
         std::tuple(other.request_class, -other.priority_px, other.request);
}

OpenRequest* RequestQueue::find(uint32_t request) {
  const auto found = requests_.find(request);
  return found == requests_.end() ? nullptr : &found->second;
}

OpenRequest* RequestQueue::first() {
  return queue_.empty() ? nullptr : &requests_.at(queue_.begin()->request);
}

void RequestQueue::add(const OpenRequest& request) {
  queue_.insert(request.rank);
  try {
    requests_.emplace(request.rank.request, request);
  } catch (...) {
    queue_.erase(request.rank);
    throw;
  }
}

void RequestQueue::reprioritise(OpenRequest& request, proto::RequestClass request_class, float priority_px) {
  auto place = queue_.extract(request.rank);
  request.rank.request_class = request_class;
  request.rank.priority_px = priority_px;
  if (place.empty()) return;
  place.value() = request.rank;
  queue_.insert(std::move(place));
}

void RequestQueue::park(OpenRequest& request) {
  queue_.erase(request.rank);
  request.parked = true;
}

void RequestQueue::unpark(OpenRequest& request) {
  queue_.insert(request.rank);
  request.parked = false;
}

void RequestQueue::end(OpenRequest& request) {
  const uint32_t number = request.rank.request;
  queue_.erase(request.rank);
  requests_.erase(number);
}

void RequestQueue::clear() {
  queue_.clear();
  requests_.clear();
}

}  // namespace lode::serve
