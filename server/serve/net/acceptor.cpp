#include "server/serve/net/acceptor.h"

#include <exception>
#include <new>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/printable.h"
#include "server/serve/memory/memory_reserve.h"

namespace lode::serve {

namespace {

using asio::ip::tcp;

constexpr auto kAcceptPause = std::chrono::milliseconds(100);  ///< pause after a failed accept()
constexpr auto kSweepEvery = std::chrono::milliseconds(100);
/// Value of TCP_NOTSENT_LOWAT. The value is small, because an urgent blob cannot overtake bytes that are
/// already in the kernel.
constexpr int kNotSentLowBytes = 16 << 10;

void tune(tcp::socket& socket) {
  asio::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  using NotSentLow = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>;
  socket.set_option(NotSentLow(kNotSentLowBytes), ignored);
}

/// Returns a completion handler that clears the flag. If the coroutine ended with an exception, the handler
/// rethrows it, so that the context's run() throws it.
auto ending(bool& running) {
  return [&running](const std::exception_ptr& thrown) {
    running = false;
    if (thrown) std::rethrow_exception(thrown);
  };
}

}  // namespace

proto::Bytes nativeRefusal(const std::string& why) {
  return proto::encode(proto::ErrorMessage{proto::WireError::kLimit, 0, true, why}, 0);
}

uint64_t raiseOpenFileLimit() noexcept {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  rlimit raised = limit;
  raised.rlim_cur = limit.rlim_max;
  return setrlimit(RLIMIT_NOFILE, &raised) == 0 ? raised.rlim_cur : limit.rlim_cur;
}

void ReserveDescriptor::release() noexcept {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
}

void ReserveDescriptor::acquire() noexcept {
  if (descriptor_ < 0) descriptor_ = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

Acceptor::Acceptor(tcp::acceptor acceptor, AcceptorOptions options, Admission& admission,
                   MemoryBudget& budget, ThreadCounters& counters, Log& log, Handler handler)
    : acceptor_(std::move(acceptor)),
      options_(std::move(options)),
      admission_(admission),
      budget_(budget),
      counters_(counters),
      log_(log),
      handler_(std::move(handler)),
      sweep_(acceptor_.get_executor()) {}

void Acceptor::open() {
  if (!accepting_) asio::co_spawn(acceptor_.get_executor(), accept(), ending(accepting_));
  accepting_ = true;
  if (!sweeping_) asio::co_spawn(acceptor_.get_executor(), sweepRefused(), ending(sweeping_));
  sweeping_ = true;
}

void Acceptor::close() {
  asio::error_code ignored;
  acceptor_.close(ignored);
}

asio::awaitable<void> Acceptor::accept() {
  while (acceptor_.is_open()) {
    tcp::socket socket(acceptor_.get_executor());
    asio::error_code error;
    co_await acceptor_.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
    if (!acceptor_.is_open()) co_return;
    std::string failure = error.message();
    try {
      if (!error && !MemoryReserve::refill()) throw std::bad_alloc();
      if (!error) {
        take(std::move(socket));
        continue;
      }
      if (outOfDescriptors(error)) refuseForDescriptors();
    } catch (const std::exception& thrown) {  // memory ran out
      failure = reasonOf(thrown);
    }
    co_await pauseAfter(failure);
  }
}

asio::awaitable<void> Acceptor::pauseAfter(const std::string& failure) {
  log_.write(LogKind::kSystem, "accepting a connection failed", {{"why", failure}});
  asio::error_code ignored;
  asio::steady_timer pause(acceptor_.get_executor(), kAcceptPause);
  co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
}

asio::awaitable<void> Acceptor::sweepRefused() {
  while (acceptor_.is_open() || refusals_.size() > 0) {
    asio::error_code ignored;
    sweep_.expires_after(kSweepEvery);
    co_await sweep_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    refusals_.sweep(Refusals::Clock::now());
    log_.tick();
  }
}

bool Acceptor::outOfDescriptors(const asio::error_code& error) const noexcept {
  return error == asio::error::no_descriptors || error == asio::error_code(ENFILE, asio::system_category());
}

/// Uses the spare descriptor to accept one connection and refuse it with a reason.
void Acceptor::refuseForDescriptors() {
  reserve_.release();
  asio::error_code error;
  tcp::socket socket(acceptor_.get_executor());
  acceptor_.non_blocking(true, error);
  acceptor_.accept(socket, error);
  if (!error) {
    counters_.refused[static_cast<size_t>(RefusalReason::kDescriptors)].add();
    const proto::Bytes word = options_.refusal(
        "this server has no room for another connection; try again later, or another server");
    Refusals::refuseAtOnce(std::move(socket), tls_ ? std::span<const std::byte>() : std::span(word));
  }
  reserve_.acquire();
}

void Acceptor::take(tcp::socket socket) {
  asio::error_code error;
  const tcp::endpoint client = socket.remote_endpoint(error);
  if (error) return;  // the client has gone
  tune(socket);
  std::optional<Slot> slot = admission_.enter();
  if (!slot)
    return refuse(std::move(socket), RefusalReason::kConnections,
                  "this server is full (" + counted(admission_.total(), "connection") +
                      "); try again later, or another server");
  if (options_.count_addresses && !slot->countUnder(client.address()))
    return refuse(std::move(socket), RefusalReason::kAddress,
                  "this address has the maximum number of connections; close some");
  MemoryAccount memory(budget_);
  if (!memory.admit(options_.connection_bytes))
    return refuse(std::move(socket), RefusalReason::kMemory,
                  "this server is short of memory; try again later, or another server");
  handler_(std::move(socket), std::move(*slot), std::move(memory),
           plainAddress(client.address()).to_string());
}

void Acceptor::refuse(tcp::socket socket, RefusalReason reason, const std::string& why) {
  counters_.refused[static_cast<size_t>(reason)].add();
  asio::error_code ignored;
  const std::string client = plainAddress(socket.remote_endpoint(ignored).address()).to_string();
  log_.write(LogKind::kRefused, "a connection was refused",
             {{"client", client}, {"reason", refusalName(reason)}});
  const auto now = Refusals::Clock::now();
  proto::Bytes word = options_.refusal(why);
  if (tls_)
    refusals_.refuseUnderTls(std::move(socket), tls_, std::move(word), now);
  else
    refusals_.refuse(std::move(socket), word, now);
}

}  // namespace lode::serve
