#include "client/net/tcp_transport.h"

#include <array>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <asio/awaitable.hpp>
#include <asio/co_spawn.hpp>
#include <asio/connect.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include "client/net/name_lookup.h"
#include "common/error.h"
#include "common/start_thread.h"
#include "proto/byte_stream.h"
#include "proto/limits.h"

namespace lode::net {
namespace {

constexpr size_t kReadBytes = 64u << 10;

using asio::ip::tcp;

}  // namespace

/// An event loop and its thread.
struct TcpTransport::Thread {
  asio::io_context io{1};
  std::thread thread;
};

/// State that the transport shares with its coroutines, because they may outlive the transport on a caller's
/// loop.
struct TcpTransport::State : std::enable_shared_from_this<State> {
  State(asio::io_context& loop, Route to, std::function<void()> on_wake)
      : io(loop), route(std::move(to)), wake(std::move(on_wake)) {}

  void start() {
    asio::co_spawn(
        io, [self = shared_from_this()] { return self->run(); }, asio::detached);
  }
  void abandon() {
    abandoned = true;
    closeAll();
    room.cancel();
    work.cancel();
    deadline.cancel();
  }
  void closeAll() {
    lookup.abandon();
    asio::error_code ignored;
    connecting.close(ignored);
    if (stream) stream->close();
  }
  void wakeUp() const {
    if (!abandoned) wake();
  }
  asio::awaitable<void> connect();
  asio::awaitable<void> connectSocket();
  asio::awaitable<void> shakeHands();
  Error noAnswer() const;
  Error lost(const asio::error_code& error) const;
  asio::awaitable<void> run();
  asio::awaitable<void> readAll();
  asio::awaitable<void> writeAll();
  bool endWrite();
  asio::awaitable<void> writeUntilClosed();
  void fail(const Error& error);

  asio::io_context& io;
  const Route route;
  const std::function<void()> wake;
  bool abandoned = false;  // the TcpTransport has been destroyed
  NameLookup lookup{io};
  tcp::socket connecting{io};               // socket until the connection is established
  std::optional<proto::ByteStream> stream;  // stream after the connection is established
  bool any_received = false;
  bool connected = false, timed_out = false;  // timed_out means that no byte arrived before the deadline
  asio::steady_timer deadline{io};
  // Timer that readAll() waits for while `received` is full; cancelled when the bytes are taken.
  asio::steady_timer room{io, asio::steady_timer::time_point::max()};
  asio::steady_timer work{io,
                          asio::steady_timer::time_point::max()};  // cancelled when there are bytes to send

  bool hasRoomLocked() const { return unsent.size() + writing_bytes <= proto::kMaxQueuedAnswerBytes; }

  mutable std::mutex mutex;  // guards the members below
  proto::Bytes received, unsent;
  size_t writing_bytes = 0;  // size of the write in progress
  std::optional<Error> failure;
};

void TcpTransport::State::fail(const Error& error) {
  {
    const std::lock_guard lock(mutex);
    if (failure) return;
    failure = error;
  }
  wakeUp();
}

asio::awaitable<void> TcpTransport::State::connect() {
  deadline.expires_after(route.connect_timeout);
  deadline.async_wait([this, self = shared_from_this()](const asio::error_code& error) {
    if (error || any_received) return;
    timed_out = true;
    closeAll();
  });
  try {
    co_await connectSocket();
    co_await shakeHands();
    connected = true;
  } catch (const Error&) {
    if (!timed_out) throw;
  }
  if (timed_out) throw noAnswer();
}

Error TcpTransport::State::noAnswer() const {
  const char* const remedy =
      connected ? ": this address accepts connections; check that lodestreamd serve runs there"
                : ": check the address, the network and the firewall";
  return {ErrorCode::kTimeout, "no answer from " + toString(route.address) + " within " +
                                   std::to_string(route.connect_timeout.count()) + " ms" + remedy};
}

asio::awaitable<void> TcpTransport::State::connectSocket() {
  const std::string where = toString(route.address);
  bool resolved = false;
  try {
    const auto found = co_await lookup.find(route.address);
    resolved = true;
    co_await asio::async_connect(connecting, found, asio::use_awaitable);
    connecting.set_option(tcp::no_delay(true));
  } catch (const std::system_error& error) {
    const std::string why = where + " (" + error.code().message() + "): check ";
    throw Error(ErrorCode::kNetwork, resolved
                                         ? "cannot connect to " + why + "that lodestreamd serve runs there"
                                         : "cannot find the host of " + why + "the name");
  }
}

asio::awaitable<void> TcpTransport::State::shakeHands() {
  if (!route.tls) {
    stream.emplace(std::move(connecting));
    co_return;
  }
  stream.emplace(std::move(connecting), route.tls);
  try {
    co_await stream->connectHandshake(route.address.host);
  } catch (const Error& error) {
    const std::string what = toString(route.address) + ": " + error.what();
    if (stream->isPeerDoubted()) throw Error(ErrorCode::kNetwork, what, Remedy::kCertificate);
    throw Error(ErrorCode::kNetwork, what + "; use lode:// if it serves no TLS");
  }
}

/// Returns the error for a connection that has ended.
Error TcpTransport::State::lost(const asio::error_code& error) const {
  const std::string where = toString(route.address);
  if (timed_out) return noAnswer();
  if (error != asio::error::eof)
    return {ErrorCode::kNetwork, "the connection to " + where + " broke (" + error.message() +
                                     "): check the network and the server"};
  if (!any_received && !route.tls)
    return {ErrorCode::kNetwork, where + " closed the connection without an answer: use lodes:// if it " +
                                     "serves TLS, or look into its log"};
  return {ErrorCode::kNetwork, where + " closed the connection: look into the server's log"};
}

asio::awaitable<void> TcpTransport::State::run() {
  try {
    co_await connect();
    asio::co_spawn(
        io, [self = shared_from_this()] { return self->writeUntilClosed(); }, asio::detached);
    co_await readAll();
  } catch (const Error& error) {
    fail(error);
  } catch (const std::bad_alloc&) {
    fail(Error(ErrorCode::kIo, kOutOfMemory));
  } catch (const std::exception& error) {
    fail(Error(ErrorCode::kInternal, error.what()));
  }
  deadline.cancel();
}

asio::awaitable<void> TcpTransport::State::readAll() {
  std::vector<std::byte> buffer(kReadBytes);
  while (true) {
    asio::error_code error;
    const size_t count = co_await stream->readSome(asio::buffer(buffer), error);
    if (error) throw lost(error);
    if (!std::exchange(any_received, true)) deadline.cancel();
    bool full = false;
    {
      const std::lock_guard lock(mutex);
      received.insert(received.end(), buffer.begin(), buffer.begin() + static_cast<ptrdiff_t>(count));
      full = received.size() >= kMaxReceivedBytes;
    }
    wakeUp();
    while (full && !abandoned) {
      asio::error_code cancelled;
      co_await room.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
      const std::lock_guard lock(mutex);
      full = received.size() >= kMaxReceivedBytes;
    }
  }
}

asio::awaitable<void> TcpTransport::State::writeAll() {
  while (!abandoned) {
    proto::Bytes bytes;
    {
      const std::lock_guard lock(mutex);
      bytes.swap(unsent);
      writing_bytes = bytes.size();
    }
    if (bytes.empty()) {
      asio::error_code cancelled;
      co_await work.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
    } else {
      const asio::const_buffer whole = asio::buffer(bytes);
      asio::error_code error;
      co_await stream->write(std::span(&whole, 1), error);
      if (error) co_return;  // readAll() reports the end of the connection, after all received bytes
      if (endWrite()) wakeUp();
    }
  }
}

/// Notes the end of a write. @return true if this changes hasRoom() from false to true.
bool TcpTransport::State::endWrite() {
  const std::lock_guard lock(mutex);
  const bool had_room = hasRoomLocked();
  writing_bytes = 0;
  return !had_room && hasRoomLocked();
}

asio::awaitable<void> TcpTransport::State::writeUntilClosed() {
  try {
    co_await writeAll();
  } catch (const std::exception&) {
    // readAll() reports the end of the connection, after all received bytes.
  }
}

TcpTransport::TcpTransport(Route route, std::function<void()> wake)
    : own_thread_(std::make_unique<Thread>()),
      state_(std::make_shared<State>(own_thread_->io, std::move(route), std::move(wake))) {
  state_->start();
  own_thread_->thread = startThread("for a connection", [io = &own_thread_->io] { io->run(); });
}

TcpTransport::TcpTransport(asio::io_context& io, Route route, std::function<void()> wake)
    : state_(std::make_shared<State>(io, std::move(route), std::move(wake))) {
  state_->start();
}

TcpTransport::~TcpTransport() {
  if (own_thread_) {
    own_thread_->io.stop();
    own_thread_->thread.join();
  }
  state_->abandon();
}

bool TcpTransport::hasRoom() const {
  const std::lock_guard lock(state_->mutex);
  return state_->hasRoomLocked();
}

void TcpTransport::send(proto::Bytes bytes) {
  if (bytes.empty()) return;
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->unsent.size() + bytes.size() > kMaxUnsentBytes)
      throw Error(ErrorCode::kNetwork,
                  toString(state_->route.address) + " accepts no data: check the server and try again");
    state_->unsent.insert(state_->unsent.end(), bytes.begin(), bytes.end());
  }
  asio::post(state_->io, [state = state_] { state->work.cancel(); });
}

proto::Bytes TcpTransport::takeReceived() {
  proto::Bytes bytes;
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->received.empty() && state_->failure) throw *state_->failure;
    bytes.swap(state_->received);
  }
  if (bytes.size() >= kMaxReceivedBytes) asio::post(state_->io, [state = state_] { state->room.cancel(); });
  return bytes;
}

}  // namespace lode::net
