#include "server/serve/net/connection.h"

#include <array>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "common/error.h"
#include "common/release_storage.h"
#include "server/serve/net/proxy_header.h"

namespace lode::serve {

namespace {

constexpr size_t kMaxKeptBodyBytes = 4u << 10;  ///< largest capacity kept for the next frame

LogKind kindOfEnd(EndReason reason, bool unauthorized) {
  if (reason == EndReason::kTls || reason == EndReason::kProxyHeader) return LogKind::kProtocolMistake;
  if (reason != EndReason::kMistake) return LogKind::kConnectionEnd;
  return unauthorized ? LogKind::kUnauthorized : LogKind::kProtocolMistake;
}

}  // namespace

Connection::Connection(proto::ByteStream stream, Slot slot, MemoryAccount memory, ConnectionHost& host,
                       ConnectionLimits limits, std::string client)
    : slot_(std::move(slot)),
      memory_(std::move(memory)),
      reading_(*host.budget),
      host_(host),
      limits_(limits),
      stream_(std::move(stream), 2048, [this](size_t more) { return memory_.tryTake(more); }),
      session_({&host.served, &memory_, host.counters}, limits.session, Clock::now()),
      rate_(limits.bytes_per_second),
      to_write_(stream_.bytes().executor(), asio::steady_timer::time_point::max()),
      to_read_(stream_.bytes().executor(), asio::steady_timer::time_point::max()),
      client_(std::move(client)) {
  host_.connections.insert(this);
}

Connection::~Connection() {
  host_.connections.erase(this);
  const EndReason reason = end_.value_or(EndReason::kStopping);
  host_.counters->ended[static_cast<size_t>(reason)].add();
  const double seconds = std::chrono::duration<double>(Clock::now() - began_).count();
  const std::array<LogField, 7> fields{{{"client", client_},
                                        {"reason", endName(reason)},
                                        {"seconds", seconds},
                                        {"frames", frames_},
                                        {"blobs", blobs_},
                                        {"bytes", sent_bytes_},
                                        {"why", why_}}};
  host_.log->write(kindOfEnd(reason, session_.unauthorized()), "a connection ended",
                   std::span(fields).first(fields.size() - (why_.empty() ? 1 : 0)));
}

void Connection::start() {
  asio::co_spawn(
      stream_.bytes().executor(), [self = shared_from_this()] { return self->read(); }, asio::detached);
}

void Connection::startWriting() {
  asio::co_spawn(
      stream_.bytes().executor(), [self = shared_from_this()] { return self->write(); }, asio::detached);
}

void Connection::drain(const std::string& reason) {
  session_.drain(reason, Clock::now());
  wakeWriter();
}

void Connection::servedSetChanged() {
  session_.servedSetChanged();
  wakeWriter();
}

void Connection::end(EndReason reason) {
  if (!end_) end_ = reason;
}

void Connection::sweep(Clock::time_point now) {
  session_.checkExpiry(std::chrono::system_clock::now());
  const bool is_unresponsive = session_.stopWaitingForPong(now) && session_.finished();
  if (is_unresponsive) end(EndReason::kStopping);
  if (session_.finished() && !linger_until_) wakeWriter();
  const bool late = now >= session_.deadline();
  const bool stalled = writing_since_ && now >= *writing_since_ + limits_.write;
  if (late) end(session_.greeted() ? EndReason::kIdle : EndReason::kHandshake);
  if (stalled) end(EndReason::kStalled);
  if (late || stalled || is_unresponsive || (linger_until_ && now >= *linger_until_)) stream_.close();
}

void Connection::endForMemory() {
  end(EndReason::kMemory);
  memory_.leave();
  session_.refuse(proto::WireError::kLimit,
                  "the server is short of memory, and this connection holds much of it");
  wakeWriter();
  wakeReader();
}

void Connection::wakeWriter() {
  write_woken_ = true;
  to_write_.cancel();
}

void Connection::wakeReader() {
  read_woken_ = true;
  to_read_.cancel();
}

asio::awaitable<void> Connection::sleep(asio::steady_timer& until, bool& woken) {
  asio::error_code cancelled;
  if (!woken) co_await until.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
  woken = false;
}

asio::awaitable<void> Connection::read() {
  bool broken = false;
  try {
    if (co_await greet()) {
      startWriting();
      co_await readFrames();
    }
  } catch (const Error& error) {
    const bool is_cut_off = error.code() == ErrorCode::kNetwork;
    broken = is_cut_off && !session_.closing();  // a refused client may cut the connection
    if (broken) end(EndReason::kBroken);
    if (!is_cut_off)
      session_.refuse(
          error.code() == ErrorCode::kLimit ? proto::WireError::kLimit : proto::WireError::kMalformed,
          error.what());
  } catch (const std::exception&) {  // memory ran out: end this connection only
    end(EndReason::kMemory);
    broken = true;
  }
  if (session_.closing() && !broken) {
    if (!end_) why_ = session_.refusal();
    end(EndReason::kMistake);
    if (session_.unauthorized()) host_.counters->refused[static_cast<size_t>(RefusalReason::kToken)].add();
    if (holds_answer_) co_await delayAnswer();
    wakeWriter();  // the writer sends the Error; further frames are discarded
    co_await stream_.discard();
  } else {
    end(EndReason::kClient);
    stream_.close();
  }
  gone_ = true;
  wakeWriter();
}

/// Refuses a client without a successful Hello if WrongTokens blocks its address. @return true if the client
/// is refused.
bool Connection::refuseUnheard() {
  if (session_.greeted() || !host_.served.tokens) return false;
  asio::error_code ignored;
  const uint64_t address = addressKey(asio::ip::make_address(client_, ignored));
  if (!host_.wrong_tokens->blocks(address, Clock::now())) return false;
  host_.counters->refused[static_cast<size_t>(RefusalReason::kToken)].add();
  session_.refuse(proto::WireError::kLimit, "this address sent too many wrong tokens; try again later");
  return true;
}

/// Waits before the answer to a wrong token. Before the wait, the connection releases its slot and its memory
/// for other connections.
asio::awaitable<void> Connection::delayAnswer() {
  try {
    asio::error_code ignored;
    const uint64_t address = addressKey(asio::ip::make_address(client_, ignored));
    const std::optional<WrongTokens::Wait> wait = host_.wrong_tokens->add(address, Clock::now());
    if (wait) {
      { const Slot left = std::move(slot_); }
      { const MemoryAccount left = std::move(memory_); }
      asio::steady_timer answer(stream_.bytes().executor(), wait->until());
      co_await answer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    }
  } catch (const std::exception&) {  // memory ran out: answer at once
  }
  holds_answer_ = false;
}

/// Reads the balancer's header and performs the TLS handshake. @return false if the client closed the
/// connection before sending anything.
asio::awaitable<bool> Connection::greet() {
  if (limits_.proxy_protocol) {
    std::optional<ProxyHeader> header;
    try {
      header = co_await readProxyHeader(stream_.bytes().socket());
    } catch (const Error& error) {
      turnAway(RefusalReason::kProxyHeader, EndReason::kProxyHeader, error.what());
      throw;
    }
    if (!header) co_return false;
    if (header->client) {
      client_ = plainAddress(*header->client).to_string();
      if (!slot_.countUnder(*header->client)) {
        host_.counters->refused[static_cast<size_t>(RefusalReason::kAddress)].add();
        session_.refuse(proto::WireError::kLimit,
                        "this address has the maximum number of connections; close some");
      }
    }
  }
  try {
    co_return co_await stream_.bytes().acceptHandshake();
  } catch (const Error& error) {
    turnAway(RefusalReason::kTls, EndReason::kTls, error.what());
    throw;
  }
}

/// Records a refusal. Does nothing if the connection has already ended for another reason, such as a
/// deadline.
void Connection::turnAway(RefusalReason refused, EndReason ended, const std::string& why) {
  if (end_) return;
  host_.counters->refused[static_cast<size_t>(refused)].add();
  end(ended);
  why_ = why;
}

/// Frees the body of a frame if it is larger than kMaxKeptBodyBytes, and returns the memory charged for it to
/// the budget.
void Connection::releaseStorageOf(proto::Frame& frame) {
  if (frame.body.capacity() <= kMaxKeptBodyBytes) return;
  memory_.give(frame.body.capacity() - kMaxKeptBodyBytes);
  releaseStorage(frame.body);
}

asio::awaitable<void> Connection::readFrames() {
  proto::Frame frame;
  while (!session_.closing()) {
    while (session_.controlBytes() > limits_.queued_answer_bytes && !gone_)
      co_await sleep(to_read_, read_woken_);
    if (gone_) co_return;
    const uint32_t limit = session_.greeted() ? proto::kMaxFrameBodyBytes : proto::kMaxHelloBodyBytes;
    try {
      const bool more = co_await stream_.read(frame, limit);
      if (!more) co_return;
    } catch (...) {
      releaseStorageOf(frame);
      throw;
    }
    if (!linger_until_) {
      ++frames_;
      if (!refuseUnheard()) session_.receive(frame.header, frame.body, Clock::now());
      holds_answer_ = session_.gaveWrongToken();
      wakeWriter();
    }
    releaseStorageOf(frame);
  }
}

}  // namespace lode::serve
