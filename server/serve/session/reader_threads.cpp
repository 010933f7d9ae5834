#include "server/serve/session/reader_threads.h"

#include <exception>

#include "common/start_thread.h"

namespace lode::serve {

namespace {

constexpr const char* kReading = "to read stores";

}  // namespace

ReaderThreads::ReaderThreads(size_t count)
    : pool_(withThreads(kReading, [] { return std::make_unique<asio::thread_pool>(1); })) {
  try {
    while (others_.size() + 1 < count)
      others_.push_back(startThread<std::jthread>(kReading, [this] { pool_->attach(); }));
  } catch (const std::exception&) {
    join();
    throw;
  }
}

void ReaderThreads::join() {
  pool_->join();
  others_.clear();
}

}  // namespace lode::serve
