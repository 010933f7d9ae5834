#include "server/serve/worker.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "server/serve/net/http_connection.h"

namespace lode::serve {

using asio::ip::tcp;

namespace {

constexpr auto kCheckMemoryEvery = std::chrono::milliseconds(20);

}  // namespace

Worker::Worker(Published published, const WorkerShared& shared, ThreadCounters& counters)
    : budget_(shared.budget), limits_(shared.limits), guard_(context_.get_executor()), tick_(context_) {
  host_.served = std::move(published.served);
  host_.tls = std::move(published.tls);
  host_.is_public = shared.is_public;
  host_.log = &shared.log;
  host_.counters = &counters;
  host_.readers = &shared.readers;
  host_.rate = &shared.rate;
  host_.budget = &shared.budget;
  host_.wrong_tokens = &shared.wrong_tokens;
  host_.http = shared.http;
}

void Worker::start(Clock::duration sweep_every) {
  asio::co_spawn(context_, sweep(sweep_every), asio::detached);
  thread_ = std::thread([this] {
    while (true) try {
        context_.run();
        return;
      } catch (const std::exception& error) {  // usually memory ran out; the other connections continue
        host_.log->write(LogKind::kSystem, reasonOf(error));
      }
  });
}

void Worker::join() {
  if (thread_.joinable()) thread_.join();
}

void Worker::give(tcp::socket socket, Slot slot, MemoryAccount memory, std::string client,
                  ClientProtocol protocol) {
  slot.countIn(load_);
  const auto family = socket.local_endpoint().protocol();
  tcp::socket own(context_);
  own.assign(family, socket.release());
  asio::post(context_, [this, own = std::move(own), slot = std::move(slot), memory = std::move(memory),
                        client = std::move(client), protocol]() mutable {
    admit(std::move(own), std::move(slot), std::move(memory), std::move(client), protocol);
  });
}

void Worker::admit(tcp::socket socket, Slot slot, MemoryAccount memory, std::string client,
                   ClientProtocol protocol) {
  try {
    proto::ByteStream stream =
        host_.tls ? proto::ByteStream(std::move(socket), host_.tls) : proto::ByteStream(std::move(socket));
    if (protocol == ClientProtocol::kHttp)
      start(std::make_shared<HttpConnection>(std::move(stream), std::move(slot), std::move(memory), host_,
                                             limits_, std::move(client)));
    else
      start(std::make_shared<Connection>(std::move(stream), std::move(slot), std::move(memory), host_,
                                         limits_, std::move(client)));
  } catch (const std::exception& error) {  // memory ran out
    host_.log->write(LogKind::kSystem, "a connection was dropped", {{"why", reasonOf(error)}});
  }
}

template <typename Kind>
void Worker::start(std::shared_ptr<Kind> connection) {
  host_.counters->accepted.add();
  connection->start();
  if (!draining_.empty()) connection->drain(draining_);
}

void Worker::publish(const Published& published) {
  asio::post(context_, [this, published] {
    host_.served = published.served;
    host_.tls = published.tls;
    for (ClientConnection* connection : host_.connections) connection->servedSetChanged();
  });
}

void Worker::drain(const std::string& reason) {
  asio::post(context_, [this, reason] {
    draining_ = reason;
    for (ClientConnection* connection : host_.connections) connection->drain(reason);
  });
}

asio::awaitable<void> Worker::sweep(Clock::duration every) {
  auto next = Clock::now() + every;
  while (true) {
    asio::error_code error;
    tick_.expires_after(std::min<Clock::duration>(every, kCheckMemoryEvery));
    co_await tick_.async_wait(asio::redirect_error(asio::use_awaitable, error));
    const auto now = Clock::now();
    if (now < next && !budget_.tight()) continue;
    next = now + every;
    sweepNow(now);
  }
}

void Worker::sweepNow(Clock::time_point now) {
  for (ClientConnection* connection : host_.connections) connection->sweep(now);
  if (budget_.pressed()) closeLargest();
}

/// Closes this thread's largest connections until the budget is relieved. Keeps all connections that use less
/// memory than the average connection of the server, or less than half of kPoliteBytes.
void Worker::closeLargest() {
  const uint64_t mean = budget_.mean();
  std::vector<ClientConnection*> largest;
  for (ClientConnection* connection : host_.connections)
    if (connection->heldBytes() >= std::max(mean, kPoliteBytes / 2)) largest.push_back(connection);
  std::ranges::sort(largest, std::ranges::greater(),
                    [](const ClientConnection* c) { return c->heldBytes(); });
  for (auto next = largest.begin(); next != largest.end() && !budget_.relieved(); ++next)
    (*next)->endForMemory();
}

}  // namespace lode::serve
