#include "client/stream/decode_pool.h"

#include <algorithm>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

namespace lode::stream {
namespace {

constexpr int kNice = 10;  // decoding must not take the renderer's time

unsigned threadCount(unsigned wanted) {
  if (wanted != 0) return wanted;
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 3 ? cores - 2 : 1;
}

}  // namespace

DecodePool::DecodePool(unsigned threads, std::function<void()> wake)
    : wake_(std::move(wake)), jobs_(kMaxWaitingJobs) {
  for (unsigned i = 0; i < threadCount(threads); ++i) threads_.emplace_back([this] { work(); });
}

DecodePool::~DecodePool() {
  stopping_ = true;
  jobs_.close();
  for (std::thread& thread : threads_) thread.join();
}

void DecodePool::add(std::vector<core::DecodeJob> jobs) {
  for (core::DecodeJob& job : jobs) jobs_.push(std::move(job));
}

std::vector<core::DecodeResult> DecodePool::takeResults() {
  const std::lock_guard lock(mutex_);
  return std::exchange(results_, {});
}

void DecodePool::work() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  while (std::optional<core::DecodeJob> job = jobs_.pop()) {
    if (stopping_) return;
    core::DecodeResult result = core::runDecodeJob(*job);
    {
      const std::lock_guard lock(mutex_);
      results_.push_back(std::move(result));
    }
    wake_();
  }
}

}  // namespace lode::stream
