#include "client/stream/decode_pool.h"

#include <algorithm>
#include <string>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include "common/error.h"
#include "common/start_thread.h"

namespace lode::stream {
namespace {

constexpr int kNice = 10;  // nice value of the threads, so that the render thread takes precedence

unsigned threadCount(unsigned wanted) {
  if (wanted > kMaxDecodeThreads)
    throw Error(ErrorCode::kUsage, std::to_string(wanted) + " decode threads are more than " +
                                       std::to_string(kMaxDecodeThreads) + ": give fewer");
  return wanted != 0 ? wanted : defaultDecodeThreads();
}

}  // namespace

unsigned defaultDecodeThreads() noexcept {
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 3 ? std::min(cores - 2, kMaxDecodeThreads) : 1;
}

DecodePool::DecodePool(unsigned threads, std::function<void()> wake)
    : wake_(std::move(wake)), jobs_(kMaxWaitingJobs) {
  const unsigned count = threadCount(threads);
  threads_.reserve(count);
  try {
    for (unsigned i = 0; i < count; ++i) threads_.push_back(startThread("to decode", [this] { work(); }));
  } catch (const std::exception&) {
    stop();
    throw;
  }
}

DecodePool::~DecodePool() { stop(); }

void DecodePool::stop() {
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
