#pragma once

#include <memory>
#include <vector>

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "client/net/address.h"

namespace lode::net {

/// Resolves one host name. The system's lookup cannot be cancelled and may take a minute, so the lookup runs
/// on a detached thread, which accesses only state that it shares with this object. Use the object on the
/// event loop's thread.
class NameLookup {
 public:
  /// @param io  event loop, which must outlive the object.
  explicit NameLookup(asio::io_context& io);
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

  /// Returns the endpoints of an address; IP addresses need no lookup.
  /// @throws std::system_error if the name is unknown, or after abandon().
  asio::awaitable<std::vector<asio::ip::tcp::endpoint>> find(Address address);
  /// Makes a pending find() fail at once. While the loop is not running, any thread may call abandon().
  void abandon();

 private:
  struct Shared;
  static void ask(Shared& shared, const Address& address);

  std::shared_ptr<Shared> shared_;
  // Timer that find() waits for; cancelled when the lookup has ended or is abandoned.
  std::shared_ptr<asio::steady_timer> answered_;
};

}  // namespace lode::net
