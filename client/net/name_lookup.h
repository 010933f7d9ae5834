#pragma once

#include <memory>
#include <vector>

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "client/net/address.h"

namespace lode::net {

/// The endpoints of one address. The system's look-up cannot be ended and may take a minute; it runs on a
/// thread that nobody waits for, and that touches nothing but what it shares with this object. For the loop's
/// thread.
class NameLookup {
 public:
  /// @param io  outlives the object.
  explicit NameLookup(asio::io_context& io);
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

  /// Numbers are not looked up. @throws std::system_error where the name is not known, or after abandon().
  asio::awaitable<std::vector<asio::ip::tcp::endpoint>> find(Address address);
  /// A find() under way fails at once. While the loop does not run, any thread may call it.
  void abandon();

 private:
  struct Shared;
  static void ask(Shared& shared, const Address& address);

  std::shared_ptr<Shared> shared_;
  std::shared_ptr<asio::steady_timer> answered_;  // cancelled: there is an answer, or none will come
};

}  // namespace lode::net
