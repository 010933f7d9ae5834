#include "client/core/cache/postponed_blobs.h"

#include <algorithm>
#include <utility>

namespace lode::core {

void PostponedBlobs::add(uint32_t blob, const std::string& why, TimePoint now) {
  if (why_.empty()) why_ = why;
  if (waiting_.empty()) {
    due_ = now + pause_;
    pause_ = std::min<std::chrono::milliseconds>(pause_ * 3 / 2, kLastRepeat);
  }
  released_.erase(blob);
  if (waiting_.size() >= kMaxPostponedBlobs) waiting_.clear();
  waiting_.insert(blob);
}

void PostponedBlobs::arrived(uint32_t blob) {
  waiting_.erase(blob);
  released_.erase(blob);
  endIfEmpty();
}

bool PostponedBlobs::release(TimePoint now) {
  if (why_.empty() || now < due_) return false;
  released_ = std::exchange(waiting_, {});
  due_ = now + pause_;
  endIfEmpty();
  return !released_.empty();
}

void PostponedBlobs::endIfEmpty() {
  if (!waiting_.empty() || !released_.empty()) return;
  why_.clear();
  pause_ = kFirstRepeat;
}

}  // namespace lode::core
