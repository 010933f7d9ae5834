#include "server/serve/ops/log.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <new>
#include <string>
#include <utility>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <spdlog/async_logger.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/base_sink.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/printable.h"

namespace lode::serve {

namespace {

/// Largest number of bytes that a line shows of the message and of each field.
constexpr size_t kMaxShownBytes = 1024;

std::string toIso(std::chrono::system_clock::time_point time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  const std::time_t seconds = ms / 1000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  const size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text.data() + length, text.size() - length, ".%03dZ", static_cast<int>(ms % 1000));
  return text.data();
}

/// Replaces unprintable bytes, so that text from clients cannot move a terminal's cursor or forge a line.
std::string printable(std::string_view text) {
  std::string shown(text.substr(0, kMaxShownBytes));
  if (isPrintableUtf8(shown)) return shown;
  for (char& c : shown)
    if (c < 0x20 || c > 0x7E) c = '?';
  return shown;
}

std::string asText(const LogField& field) {
  if (const auto* count = std::get_if<uint64_t>(&field.value)) return std::to_string(*count);
  if (const auto* text = std::get_if<std::string_view>(&field.value)) return printable(*text);
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.6g", std::get<double>(field.value));
  return number.data();
}

nlohmann::ordered_json asJson(const LogField& field) {
  if (const auto* count = std::get_if<uint64_t>(&field.value)) return *count;
  if (const auto* text = std::get_if<std::string_view>(&field.value)) return printable(*text);
  return std::get<double>(field.value);
}

std::string jsonLine(const std::string& time, LogKind kind, std::string_view message,
                     std::span<const LogField> fields) {
  nlohmann::ordered_json json;
  json["time"] = time;
  json["kind"] = logKindName(kind);
  json["message"] = printable(message);
  for (const LogField& field : fields) json[std::string(field.name)] = asJson(field);
  return json.dump();
}

std::string textLine(const std::string& time, LogKind kind, std::string_view message,
                     std::span<const LogField> fields) {
  std::string line = time + ' ' + std::string(logKindName(kind)) + ": " + printable(message);
  std::string_view before = " (";
  for (const LogField& field : fields) {
    line += std::string(before) + std::string(field.name) + '=' + asText(field);
    before = ", ";
  }
  if (!fields.empty()) line += ')';
  return line;
}

/// Passes formatted lines to a LogSink. Runs on spdlog's thread only.
class DescriptorSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  DescriptorSink(int descriptor, bool json, std::atomic<uint64_t>& dropped)
      : sink_(descriptor), json_(json), dropped_(dropped) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (unreported_ > 0) {
      const LogField lines{"lines", unreported_};
      if (sink_.write(logLine(json_, message.time, LogKind::kServer,
                              "log lines were lost because nobody read them", {&lines, 1})))
        unreported_ = 0;
    }
    if (sink_.write({message.payload.data(), message.payload.size()})) return;
    ++unreported_;
    dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  void flush_() override {}

 private:
  LogSink sink_;
  bool json_;
  std::atomic<uint64_t>& dropped_;
  uint64_t unreported_ = 0;
};

/// Blocks SIGPIPE, which would end the process. If the reader has gone, write() then fails with EPIPE.
void blockSigpipe() {
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
}

}  // namespace

LogLimit::Bucket& LogLimit::fill(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = buckets_[static_cast<size_t>(kind)];
  const double seconds = std::chrono::duration<double>(std::max(now, bucket.filled) - bucket.filled).count();
  bucket.lines = std::min(kBurst, bucket.lines + seconds * kPerSecond);
  bucket.filled = std::max(now, bucket.filled);
  return bucket;
}

bool LogLimit::admit(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = fill(kind, now);
  if (bucket.lines < 1) {
    ++bucket.left_out;
    return false;
  }
  bucket.lines -= 1;
  return true;
}

uint64_t LogLimit::takeLeftOut(LogKind kind, TimePoint now) noexcept {
  Bucket& bucket = fill(kind, now);
  return bucket.left_out > 0 && bucket.lines >= 1 ? std::exchange(bucket.left_out, 0) : 0;
}

std::string_view logKindName(LogKind kind) noexcept {
  constexpr std::array<std::string_view, kLogKinds> kNames{
      "server", "connection", "refused", "unauthorized", "mistake", "damage", "unreadable", "system"};
  return kNames[static_cast<size_t>(kind)];
}

std::string logLine(bool json, std::chrono::system_clock::time_point time, LogKind kind,
                    std::string_view message, std::span<const LogField> fields) {
  const auto render = json ? jsonLine : textLine;
  std::string line = render(toIso(time), kind, message, fields);
  if (line.size() >= kMaxLogLineBytes) line = render(toIso(time), kind, message, {});
  return line += '\n';
}

LogSink::LogSink(int descriptor) noexcept : descriptor_(descriptor) {
  struct stat about {};
  if (fstat(descriptor, &about) != 0) return;
  is_socket_ = S_ISSOCK(about.st_mode);
  if (!S_ISFIFO(about.st_mode)) return;
  const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
  own_ = open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
}

LogSink::~LogSink() {
  if (own_ >= 0) close(own_);
}

bool LogSink::ready() const noexcept {
  pollfd waiting{descriptor_, POLLOUT, 0};
  return poll(&waiting, 1, 0) == 1 && (waiting.revents & POLLOUT) != 0;
}

bool LogSink::write(std::string_view line) noexcept {
  ssize_t taken = -1;
  if (is_socket_)
    taken = send(descriptor_, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  else if (own_ >= 0)
    taken = ::write(own_, line.data(), line.size());
  else if (ready())
    taken = ::write(descriptor_, line.data(), line.size());
  return taken == static_cast<ssize_t>(line.size());
}

struct Log::State {
  explicit State(LogOptions wanted)
      : options(std::move(wanted)),
        pool(std::make_shared<spdlog::details::thread_pool>(options.queue_lines, 1, blockSigpipe)),
        logger(std::make_shared<spdlog::async_logger>(
            "lodestreamd", std::make_shared<DescriptorSink>(options.descriptor, options.json, dropped), pool,
            spdlog::async_overflow_policy::overrun_oldest)) {
    // Replace the default handler, which writes to stderr and can block.
    logger->set_error_handler([](const std::string&) {});
  }
  ~State() { pool.reset(); }  // joins the thread first, because the thread uses the sink and the counter
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
  std::mutex mutex;  ///< guards limit
  LogLimit limit;
  std::shared_ptr<spdlog::details::thread_pool> pool;
  std::shared_ptr<spdlog::async_logger> logger;
};

std::string_view reasonOf(const std::exception& error) noexcept {
  return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ? "the system has no memory left"
                                                                : error.what();
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
  } catch (const std::exception&) {  // out of memory
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
