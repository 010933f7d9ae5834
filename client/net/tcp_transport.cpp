#include "client/net/tcp_transport.h"

#include <array>
#include <exception>
#include <mutex>
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
#include <asio/write.hpp>

#include "common/error.h"

namespace lode::net {
namespace {

constexpr size_t kReadBytes = 64u << 10;

using asio::ip::tcp;

}  // namespace

/// A loop with a thread that runs it.
struct TcpTransport::Thread {
  asio::io_context io{1};
  std::thread thread;
};

/// The coroutines keep it; on a caller's loop they end some time after the transport.
struct TcpTransport::State : std::enable_shared_from_this<State> {
  State(asio::io_context& loop, Address to, std::chrono::milliseconds timeout, std::function<void()> on_wake)
      : io(loop), address(std::move(to)), connect_timeout(timeout), wake(std::move(on_wake)) {}

  void start() {
    asio::co_spawn(
        io, [self = shared_from_this()] { return self->run(); }, asio::detached);
  }
  void abandon() {
    abandoned = true;
    asio::error_code ignored;
    resolver.cancel();
    socket.close(ignored);
    room.cancel();
    work.cancel();
  }
  void wakeUp() const {
    if (!abandoned) wake();
  }
  asio::awaitable<void> connect();
  asio::awaitable<void> run();
  asio::awaitable<void> readAll();
  asio::awaitable<void> writeAll();
  asio::awaitable<void> writeUntilClosed();
  void fail(ErrorCode code, const std::string& message);

  asio::io_context& io;
  const Address address;
  const std::chrono::milliseconds connect_timeout;
  const std::function<void()> wake;
  bool abandoned = false;  // the transport is gone
  tcp::socket socket{io};
  tcp::resolver resolver{io};
  bool connected = false, timed_out = false;  // of connect() and its deadline, which may fire after it
  asio::steady_timer room{io, asio::steady_timer::time_point::max()};  // cancelled: received bytes were taken
  asio::steady_timer work{io,
                          asio::steady_timer::time_point::max()};  // cancelled: there is something to send

  std::mutex mutex;  // of what follows
  proto::Bytes received, unsent;
  std::optional<Error> failure;
};

void TcpTransport::State::fail(ErrorCode code, const std::string& message) {
  {
    const std::lock_guard lock(mutex);
    if (failure) return;
    failure.emplace(code, message);
  }
  wakeUp();
}

asio::awaitable<void> TcpTransport::State::connect() {
  asio::steady_timer deadline(io, connect_timeout);
  deadline.async_wait([this, self = shared_from_this()](const asio::error_code& error) {
    if (error || connected) return;
    timed_out = true;
    resolver.cancel();
    socket.close();
  });
  bool resolved = false;
  try {
    const auto found =
        co_await resolver.async_resolve(address.host, std::to_string(address.port), asio::use_awaitable);
    resolved = true;
    co_await asio::async_connect(socket, found, asio::use_awaitable);
    connected = true;
    socket.set_option(tcp::no_delay(true));
  } catch (const std::system_error& error) {
    if (timed_out)
      throw Error(ErrorCode::kTimeout, "no answer from " + toString(address) + " within " +
                                           std::to_string(connect_timeout.count()) +
                                           " ms: check the address, the network and the firewall");
    if (!resolved)
      throw Error(ErrorCode::kNetwork, "cannot find the host of " + toString(address) + " (" +
                                           error.code().message() + "): check the name");
    throw Error(ErrorCode::kNetwork, "cannot connect to " + toString(address) + " (" +
                                         error.code().message() +
                                         "): check that lodestreamd serve runs there");
  }
  deadline.cancel();
}

asio::awaitable<void> TcpTransport::State::run() {
  try {
    co_await connect();
    asio::co_spawn(
        io, [self = shared_from_this()] { return self->writeUntilClosed(); }, asio::detached);
    co_await readAll();
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::system_error& error) {
    fail(ErrorCode::kNetwork, error.code() == asio::error::eof
                                  ? toString(address) + " closed the connection: look into the server's log"
                                  : "the connection to " + toString(address) + " broke (" +
                                        error.code().message() + "): check the network and the server");
  } catch (const std::exception& error) {
    fail(ErrorCode::kInternal, error.what());
  }
}

asio::awaitable<void> TcpTransport::State::readAll() {
  std::vector<std::byte> buffer(kReadBytes);
  while (true) {
    const size_t count = co_await socket.async_read_some(asio::buffer(buffer), asio::use_awaitable);
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
    }
    if (bytes.empty()) {
      asio::error_code cancelled;
      co_await work.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
    } else {
      co_await asio::async_write(socket, asio::buffer(bytes), asio::use_awaitable);
    }
  }
}

asio::awaitable<void> TcpTransport::State::writeUntilClosed() {
  try {
    co_await writeAll();
  } catch (const std::exception&) {
    // The reader sees the end of the connection too, after all that came before it, and reports it.
  }
}

TcpTransport::TcpTransport(Address address, std::chrono::milliseconds connect_timeout,
                           std::function<void()> wake)
    : own_thread_(std::make_unique<Thread>()),
      state_(std::make_shared<State>(own_thread_->io, std::move(address), connect_timeout, std::move(wake))) {
  state_->start();
  own_thread_->thread = std::thread([io = &own_thread_->io] { io->run(); });
}

TcpTransport::TcpTransport(asio::io_context& io, Address address, std::chrono::milliseconds connect_timeout,
                           std::function<void()> wake)
    : state_(std::make_shared<State>(io, std::move(address), connect_timeout, std::move(wake))) {
  state_->start();
}

TcpTransport::~TcpTransport() {
  if (own_thread_) {
    own_thread_->io.stop();
    own_thread_->thread.join();
  }
  state_->abandon();
}

void TcpTransport::send(proto::Bytes bytes) {
  if (bytes.empty()) return;
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->unsent.size() + bytes.size() > kMaxUnsentBytes)
      throw Error(ErrorCode::kNetwork,
                  toString(state_->address) + " takes no bytes: check the server and try again");
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
