#include "server/serve/net/http_connection.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include "common/error.h"
#include "server/serve/net/proxy_header.h"

namespace lode::serve {

namespace {

constexpr size_t kFirstHeadBytes = 2048;  ///< size of the buffer for heads, until a longer head arrives
/// Largest size of a write. A client must receive this many bytes within the write deadline.
constexpr size_t kWriteBytes = 64u << 10;
constexpr size_t kLimitedWriteBytes = 16u << 10;  ///< largest size of a write if rates are limited
constexpr auto kHttpLinger = std::chrono::seconds(2);
/// Status of a response to a client whose address has too many connections.
constexpr int kTooManyStatus = 503;

}  // namespace

HttpConnection::HttpConnection(proto::ByteStream stream, Slot slot, MemoryAccount memory,
                               ConnectionHost& host, ConnectionLimits limits, std::string client)
    : slot_(std::move(slot)),
      memory_(std::move(memory)),
      host_(host),
      limits_(limits),
      stream_(std::move(stream)),
      rate_(limits.bytes_per_second),
      received_(kFirstHeadBytes, '\0'),
      head_deadline_(Clock::now() + limits.session.handshake),
      client_(std::move(client)) {
  host_.connections.insert(this);
}

HttpConnection::~HttpConnection() {
  host_.connections.erase(this);
  if (is_websocket_) return;  // the WebSocket's Connection counts its end
  const EndReason reason = end_.value_or(EndReason::kStopping);
  host_.counters->ended[static_cast<size_t>(reason)].add();
  const double seconds = std::chrono::duration<double>(Clock::now() - began_).count();
  const std::array<LogField, 6> fields{{{"client", client_},
                                        {"reason", endName(reason)},
                                        {"seconds", seconds},
                                        {"requests", requests_},
                                        {"bytes", sent_bytes_},
                                        {"why", why_}}};
  const bool is_mistake =
      reason == EndReason::kMistake || reason == EndReason::kTls || reason == EndReason::kProxyHeader;
  host_.log->write(is_mistake ? LogKind::kProtocolMistake : LogKind::kConnectionEnd,
                   "an HTTP connection ended",
                   std::span(fields).first(fields.size() - (why_.empty() ? 1 : 0)));
}

void HttpConnection::start() {
  asio::co_spawn(
      stream_.executor(), [self = shared_from_this()] { return self->run(); }, asio::detached);
}

void HttpConnection::end(EndReason reason) {
  if (!end_) end_ = reason;
}

void HttpConnection::drain(const std::string&) {
  draining_ = true;
  if (!is_idle_) return;  // the response to the current request is the last one
  end(EndReason::kStopping);
  stream_.close();
}

void HttpConnection::sweep(Clock::time_point now) {
  const bool late = head_deadline_ && now >= *head_deadline_;
  const bool stalled = writing_since_ && now >= *writing_since_ + limits_.write;
  if (late) end(is_idle_ && requests_ > 0 ? EndReason::kIdle : EndReason::kHandshake);
  if (stalled) end(EndReason::kStalled);
  if (late || stalled || (linger_until_ && now >= *linger_until_)) stream_.close();
}

void HttpConnection::endForMemory() {
  end(EndReason::kMemory);
  memory_.leave();
  stream_.close();
}

asio::awaitable<void> HttpConnection::run() {
  try {
    if (co_await greet()) co_await serveRequests();
    end(EndReason::kClient);
  } catch (const Error&) {  // the connection broke; greet() has recorded the reason
    end(EndReason::kBroken);
  } catch (const std::exception&) {  // memory ran out: end this connection only
    end(EndReason::kMemory);
  }
  stream_.close();
}

/// Reads the balancer's header and performs the TLS handshake. @return false if the client closed the
/// connection before sending anything.
asio::awaitable<bool> HttpConnection::greet() {
  const auto turnAway = [this](RefusalReason refused, EndReason ended, const char* why) {
    if (end_) return;
    host_.counters->refused[static_cast<size_t>(refused)].add();
    end(ended);
    why_ = why;
  };
  if (limits_.proxy_protocol) {
    std::optional<ProxyHeader> header;
    try {
      header = co_await readProxyHeader(stream_.socket());
    } catch (const Error& error) {
      turnAway(RefusalReason::kProxyHeader, EndReason::kProxyHeader, error.what());
      throw;
    }
    if (!header) co_return false;
    if (header->client) {
      client_ = plainAddress(*header->client).to_string();
      is_too_many_ = !slot_.countUnder(*header->client);
      if (is_too_many_) host_.counters->refused[static_cast<size_t>(RefusalReason::kAddress)].add();
    }
  }
  try {
    co_return co_await stream_.acceptHandshake();
  } catch (const Error& error) {
    turnAway(RefusalReason::kTls, EndReason::kTls, error.what());
    throw;
  }
}

asio::awaitable<void> HttpConnection::serveRequests() {
  while (!draining_ && !is_websocket_) {
    const std::optional<http::ParsedHead> parsed = co_await readHead();
    if (!parsed) co_return;
    ++requests_;
    bool goes_on = false;
    if (is_too_many_)
      co_await refuse(parsed->head, kTooManyStatus,
                      "this address has the maximum number of connections; close some", true);
    else if (parsed->refused_with == 0)
      goes_on = co_await answer(parsed->head);
    else
      co_await refuse(parsed->head, parsed->refused_with, std::string(parsed->why), true);
    if (is_websocket_ || (goes_on && !draining_)) continue;
    if (draining_) end(EndReason::kStopping);
    co_await linger();
    co_return;
  }
}

/// Reads until the head of a request is complete. @return nothing if the client closed the connection before
/// the first byte of a request. @throws Error kNetwork.
asio::awaitable<std::optional<http::ParsedHead>> HttpConnection::readHead() {
  size_t searched_bytes = 0;
  is_idle_ = received_bytes_ == 0;
  if (requests_ > 0 || !is_idle_)
    head_deadline_ = Clock::now() + (is_idle_ ? limits_.session.idle : limits_.session.handshake);
  while (true) {
    const std::string_view text(received_.data(), received_bytes_);
    std::optional<http::ParsedHead> parsed = http::parseHead(text, searched_bytes);
    if (parsed) {
      head_deadline_.reset();
      is_idle_ = false;
      received_.erase(0, parsed->bytes);
      received_.resize(std::max(received_.size(), kFirstHeadBytes));
      received_bytes_ -= parsed->bytes;
      co_return parsed;
    }
    searched_bytes = received_bytes_;
    if (received_bytes_ == received_.size() && !reserveForHead())
      co_return http::ParsedHead{received_bytes_, 503, "the server is short of memory", {}};
    asio::error_code error;
    const auto room = asio::buffer(received_.data() + received_bytes_, received_.size() - received_bytes_);
    const size_t bytes = co_await stream_.readSome(room, error);
    if (error == asio::error::eof && received_bytes_ == 0) co_return std::nullopt;
    if (error) throw Error(ErrorCode::kNetwork, "the connection broke: " + error.message());
    if (is_idle_ && requests_ > 0) head_deadline_ = Clock::now() + limits_.session.handshake;
    is_idle_ = false;
    received_bytes_ += bytes;
  }
}

/// Makes room for a head of the largest size. @return false if the memory budget has no room.
bool HttpConnection::reserveForHead() {
  if (!memory_.tryTake(http::kMaxHeadBytes)) return false;
  received_.resize(http::kMaxHeadBytes);
  return true;
}

uint64_t HttpConnection::addressOfClient() const {
  asio::error_code ignored;
  return addressKey(asio::ip::make_address(client_, ignored));
}

/// Sends a response. @throws Error kNetwork.
asio::awaitable<void> HttpConnection::send(http::ResponseHead response, std::span<const std::byte> body) {
  response.closes = closes_;
  host_.counters->countHttpResponse(response.status);
  std::string head = http::formatHead(response, std::time(nullptr));
  do {
    const size_t most = body.empty() ? 0 : co_await waitForTurn(std::min(body.size(), kWriteBytes));
    const std::array parts{asio::buffer(std::as_const(head)), asio::buffer(body.data(), most)};
    asio::error_code error;
    writing_since_ = Clock::now();
    co_await stream_.write(parts, error);
    writing_since_.reset();
    if (error) throw Error(ErrorCode::kNetwork, "the connection broke while writing: " + error.message());
    const uint64_t bytes = head.size() + most;
    sent_bytes_ += bytes;
    host_.counters->http_sent_bytes.add(bytes);
    head.clear();
    body = body.subspan(most);
  } while (!body.empty());
}

/// Waits until the rates allow a write. @return size of the write, at most `bytes`.
asio::awaitable<size_t> HttpConnection::waitForTurn(size_t bytes) {
  if (!rate_.limited() && !host_.rate->limited()) co_return bytes;
  bytes = std::min(bytes, kLimitedWriteBytes);
  const auto now = Clock::now();
  const auto turn = std::max(rate_.take(bytes, now), host_.rate->take(bytes, now));
  asio::error_code ignored;
  asio::steady_timer timer(stream_.executor(), turn);
  if (turn > now) co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  co_return bytes;
}

/// Waits until the client has closed the connection. If the server closed it with unread bytes, TCP would
/// reset the connection, and the client could lose the response.
asio::awaitable<void> HttpConnection::linger() {
  linger_until_ = Clock::now() + kHttpLinger;
  stream_.shutdownSend();
  asio::error_code error;
  while (!error) co_await stream_.readSome(asio::buffer(received_), error);
}

}  // namespace lode::serve
