#include "client/app/cli/overheard_wishes.h"

#include <utility>

#include "client/app/cli/whole_frames.h"
#include "common/blob.h"

namespace lode::app {
void OverheardWishes::sent(std::span<const std::byte> frames, double now) {
  forEachFrame(frames, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type != proto::FrameType::kWishes) return;
    for (const proto::WishChange& change : proto::decode<proto::Wishes>(body).changes)
      if (change.action == proto::WishAction::kAdd) wishes_[change.wish] = {change, now, {}};
  });
}

void OverheardWishes::received(std::span<const std::byte> bytes) {
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  const size_t taken = forEachFrame(input_, [&](proto::FrameType type, std::span<const std::byte> body) {
    if (type == proto::FrameType::kBlob) takeChunk(proto::decodeBlobChunk(body));
  });
  input_.erase(input_.begin(), input_.begin() + static_cast<ptrdiff_t>(taken));
}

void OverheardWishes::takeChunk(const proto::BlobChunk& chunk) {
  const auto found = wishes_.find(chunk.header.wish);
  if (found == wishes_.end()) return;  // unasked
  Wish& wish = found->second;
  wish.bytes.insert(wish.bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
  if (wish.bytes.size() < chunk.header.total_bytes) return;
  const BlobRef blob{wish.asked.blob, chunk.header.total_bytes, nameBlob(wish.bytes)};
  tell_({blob, {}, wish.asked.wish_class, wish.asked.priority_px}, wish.asked_at);
  wishes_.erase(found);
}

}  // namespace lode::app
