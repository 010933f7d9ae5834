#include "server/serve/ops/log.h"

#include <array>
#include <atomic>
#include <csignal>
#include <mutex>
#include <new>
#include <string>

#include <spdlog/async_logger.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/base_sink.h>

#include "server/serve/ops/log_sink.h"

namespace lode::serve {

namespace {

/// Hands lines that are ready to a LogSink; on the log's own thread alone.
class DescriptorSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  DescriptorSink(int descriptor, bool json, std::atomic<uint64_t>& dropped)
      : sink_(descriptor), json_(json), dropped_(dropped) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (unsaid_ > 0) {
      const LogField lines{"lines", unsaid_};
      if (sink_.write(logLine(json_, message.time, LogKind::kServer,
                              "lines of the log were lost: nobody read them", {&lines, 1})))
        unsaid_ = 0;
    }
    if (sink_.write({message.payload.data(), message.payload.size()})) return;
    ++unsaid_;
    dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  void flush_() override {}

 private:
  LogSink sink_;
  bool json_;
  std::atomic<uint64_t>& dropped_;
  uint64_t unsaid_ = 0;
};

/// A reader that is gone shows in what write() returns, not in a signal that ends the process.
void takeNoSigpipe() {
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
}

}  // namespace

struct Log::State {
  explicit State(LogOptions wanted)
      : options(std::move(wanted)),
        pool(std::make_shared<spdlog::details::thread_pool>(options.queue_lines, 1, takeNoSigpipe)),
        logger(std::make_shared<spdlog::async_logger>(
            "lodestreamd", std::make_shared<DescriptorSink>(options.descriptor, options.json, dropped), pool,
            spdlog::async_overflow_policy::overrun_oldest)) {
    logger->set_error_handler([](const std::string&) {});  // its own would write to stderr, and wait
  }
  ~State() { pool.reset(); }  // its thread ends before what it writes to goes
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void post(LogKind kind, std::string_view message, std::span<const LogField> fields) {
    const std::string line = logLine(options.json, std::chrono::system_clock::now(), kind, message, fields);
    logger->log(spdlog::level::info, spdlog::string_view_t(line.data(), line.size()));
  }
  void postLeftOut(LogKind kind, uint64_t count) {
    const LogField lines{"lines", count};
    post(kind, std::to_string(count) + " more like this were left out", {&lines, 1});
  }

  const LogOptions options;
  std::atomic<uint64_t> dropped{0}, left_out{0};
  std::mutex mutex;  ///< of the limit
  LogLimit limit;
  std::shared_ptr<spdlog::details::thread_pool> pool;
  std::shared_ptr<spdlog::async_logger> logger;
};

std::string_view reasonOf(const std::exception& error) noexcept {
  return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ? "the system gave no memory" : error.what();
}

Log::Log(LogOptions options) : state_(std::make_unique<State>(std::move(options))) {}

Log::~Log() { tick(); }

void Log::write(LogKind kind, std::string_view message, std::span<const LogField> fields) noexcept {
  try {
    const auto now = state_->options.clock();
    uint64_t left_out = 0;
    {
      const std::lock_guard lock(state_->mutex);
      left_out = state_->limit.takeLeftOut(kind, now);
      if (!state_->limit.admit(kind, now)) {
        state_->left_out.fetch_add(1, std::memory_order_relaxed);
        return;
      }
    }
    if (left_out > 0) state_->postLeftOut(kind, left_out);
    state_->post(kind, message, {fields.begin(), fields.size()});
  } catch (const std::exception&) {  // no memory for a line
    state_->dropped.fetch_add(1, std::memory_order_relaxed);
  }
}

void Log::tick() noexcept {
  try {
    const auto now = state_->options.clock();
    std::array<uint64_t, kLogKinds> left_out{};
    {
      const std::lock_guard lock(state_->mutex);
      for (size_t kind = 0; kind < kLogKinds; ++kind)
        left_out[kind] = state_->limit.takeLeftOut(static_cast<LogKind>(kind), now);
    }
    for (size_t kind = 0; kind < kLogKinds; ++kind)
      if (left_out[kind] > 0) state_->postLeftOut(static_cast<LogKind>(kind), left_out[kind]);
  } catch (const std::exception&) {
    state_->dropped.fetch_add(1, std::memory_order_relaxed);
  }
}

uint64_t Log::linesDropped() const noexcept {
  return state_->dropped.load(std::memory_order_relaxed) + state_->pool->overrun_counter();
}

uint64_t Log::linesLeftOut() const noexcept { return state_->left_out.load(std::memory_order_relaxed); }

}  // namespace lode::serve
