#include "client/app/cli/wish_clock.h"

#include "client/app/cli/whole_frames.h"

namespace lode::app {

void WishClock::sent(std::span<const std::byte> frames, core::TimePoint now, Wishes& lost) {
  forEachFrame(frames, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type != proto::FrameType::kWishes) return;
    for (const proto::WishChange& change : proto::decode<proto::Wishes>(body).changes) {
      if (change.action == proto::WishAction::kAdd) {
        const auto before = lost.extract(change.blob);
        open_[change.blob] = {change.wish, change.wish_class, before ? before.mapped().sent : now};
        blob_of_[change.wish] = change.blob;
      } else if (change.action == proto::WishAction::kCancel) {
        if (const auto found = blob_of_.find(change.wish); found != blob_of_.end())
          open_.erase(found->second);
        blob_of_.erase(change.wish);
      }
    }
  });
}

std::optional<WishClock::Wish> WishClock::arrived(uint32_t blob) {
  const auto found = open_.find(blob);
  if (found == open_.end()) return {};
  const Wish wish = found->second;
  blob_of_.erase(wish.number);
  open_.erase(found);
  return wish;
}

}  // namespace lode::app
