#include "server/serve/wish_queue.h"

#include <tuple>

namespace lode::serve {

bool Rank::operator<(const Rank& other) const noexcept {
  return std::tuple(wish_class, -priority_px, wish) <
         std::tuple(other.wish_class, -other.priority_px, other.wish);
}

OpenWish* WishQueue::find(uint32_t wish) {
  const auto found = wishes_.find(wish);
  return found == wishes_.end() ? nullptr : &found->second;
}

OpenWish* WishQueue::first() { return queue_.empty() ? nullptr : &wishes_.at(queue_.begin()->wish); }

void WishQueue::add(const OpenWish& wish) {
  queue_.insert(wish.rank);
  try {
    wishes_.emplace(wish.rank.wish, wish);
  } catch (...) {
    queue_.erase(wish.rank);
    throw;
  }
}

void WishQueue::reprioritise(OpenWish& wish, proto::WishClass wish_class, float priority_px) {
  auto place = queue_.extract(wish.rank);
  wish.rank.wish_class = wish_class;
  wish.rank.priority_px = priority_px;
  if (place.empty()) return;
  place.value() = wish.rank;
  queue_.insert(std::move(place));
}

void WishQueue::park(OpenWish& wish) {
  queue_.erase(wish.rank);
  wish.parked = true;
}

void WishQueue::unpark(OpenWish& wish) {
  queue_.insert(wish.rank);
  wish.parked = false;
}

void WishQueue::end(OpenWish& wish) {
  const uint32_t number = wish.rank.wish;
  queue_.erase(wish.rank);
  wishes_.erase(number);
}

void WishQueue::clear() {
  queue_.clear();
  wishes_.clear();
}

}  // namespace lode::serve
