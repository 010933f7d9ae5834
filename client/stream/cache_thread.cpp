#include "client/stream/cache_thread.h"

#include <algorithm>
#include <span>
#include <utility>

#include "common/start_thread.h"

namespace lode::stream {

CacheThread::CacheThread(BlobCache cache, std::function<void()> wake)
    : cache_(std::move(cache)),
      wake_(std::move(wake)),
      thread_(startThread("for the cache", [this] { work(); })) {}

CacheThread::~CacheThread() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    asked_.clear();
    work_.notify_one();
  }
  thread_.join();
}

void CacheThread::find(const std::vector<BlobRef>& blobs) {
  if (blobs.empty()) return;
  bool is_full = false;
  {
    const std::lock_guard lock(mutex_);
    const size_t fitting = std::min(blobs.size(), kMaxWaitingLookups - asked_.size());
    asked_.insert(asked_.end(), blobs.begin(), blobs.begin() + static_cast<ptrdiff_t>(fitting));
    for (const BlobRef& blob : std::span(blobs).subspan(fitting)) answers_.push_back({blob, std::nullopt});
    is_full = fitting < blobs.size();
    work_.notify_one();
  }
  if (is_full) wake_();
}

void CacheThread::keep(const BlobRef& blob, std::vector<std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (unwritten_bytes_ + bytes.size() > kMaxUnwrittenBytes) return;
  unwritten_bytes_ += bytes.size();
  unwritten_.push_back({blob, std::move(bytes)});
  work_.notify_one();
}

std::vector<CacheThread::Answer> CacheThread::takeAnswers() {
  const std::lock_guard lock(mutex_);
  return std::exchange(answers_, {});
}

void CacheThread::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [this] { return stopping_ || !asked_.empty() || !unwritten_.empty(); });
    if (!asked_.empty()) {
      const BlobRef blob = asked_.front();
      asked_.pop_front();
      lock.unlock();
      answer(blob);
      lock.lock();
    } else if (!unwritten_.empty()) {
      const Unwritten next = std::move(unwritten_.front());
      unwritten_.pop_front();
      lock.unlock();
      cache_.keep(next.blob, next.bytes);
      lock.lock();
      unwritten_bytes_ -= next.bytes.size();
    } else {
      return;
    }
  }
}

void CacheThread::answer(const BlobRef& blob) {
  Answer answer{blob, cache_.find(blob)};
  {
    const std::lock_guard lock(mutex_);
    answers_.push_back(std::move(answer));
  }
  wake_();
}

}  // namespace lode::stream
