#include "client/net/name_lookup.h"

#include <cstring>
#include <mutex>
#include <string>
#include <system_error>

#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <netdb.h>

#include "common/start_thread.h"

namespace lode::net {

using asio::ip::tcp;

struct NameLookup::Shared {
  std::mutex mutex;      // guards all members
  asio::io_context* io;  // null if the lookup is abandoned
  std::weak_ptr<asio::steady_timer> answered;
  bool done = false;
  asio::error_code error;
  std::vector<tcp::endpoint> found;
};

namespace {

asio::error_code toErrorCode(int failure) {
  if (failure == 0) return {};
  if (failure == EAI_AGAIN) return asio::error::host_not_found_try_again;
  return asio::error::host_not_found;
}

}  // namespace

NameLookup::NameLookup(asio::io_context& io)
    : shared_(std::make_shared<Shared>()),
      answered_(std::make_shared<asio::steady_timer>(io, asio::steady_timer::time_point::max())) {
  shared_->io = &io;
  shared_->answered = answered_;
}

NameLookup::~NameLookup() { abandon(); }

void NameLookup::abandon() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->io = nullptr;
  }
  answered_->cancel();
}

/// Resolves the address on the detached thread.
void NameLookup::ask(Shared& shared, const Address& address) {
  addrinfo hints{};
  hints.ai_flags = AI_ADDRCONFIG;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int failure = getaddrinfo(address.host.c_str(), nullptr, &hints, &first);
  std::vector<tcp::endpoint> found;
  for (const addrinfo* info = first; failure == 0 && info != nullptr; info = info->ai_next) {
    tcp::endpoint endpoint;
    if (info->ai_addrlen > endpoint.capacity()) continue;
    endpoint.resize(info->ai_addrlen);
    std::memcpy(endpoint.data(), info->ai_addr, info->ai_addrlen);
    endpoint.port(address.port);
    found.push_back(endpoint);
  }
  if (failure == 0) freeaddrinfo(first);
  const std::lock_guard lock(shared.mutex);
  shared.done = true;
  shared.error = toErrorCode(failure);
  shared.found = std::move(found);
  if (shared.io == nullptr) return;
  asio::post(*shared.io, [waiting = shared.answered] {
    if (const auto answered = waiting.lock()) answered->cancel();
  });
}

asio::awaitable<std::vector<tcp::endpoint>> NameLookup::find(Address address) {
  asio::error_code no_number;
  const asio::ip::address number = asio::ip::make_address(address.host, no_number);
  if (!no_number) co_return std::vector{tcp::endpoint(number, address.port)};
  startThread("to look up a name", [shared = shared_, address] { ask(*shared, address); }).detach();
  asio::error_code cancelled;
  co_await answered_->async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
  const std::lock_guard lock(shared_->mutex);
  if (!shared_->done || shared_->io == nullptr) throw std::system_error(asio::error::operation_aborted);
  if (shared_->error) throw std::system_error(shared_->error);
  co_return shared_->found;
}

}  // namespace lode::net
