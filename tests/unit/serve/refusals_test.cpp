#include "server/serve/net/refusals.h"

#include <memory>
#include <vector>

#include <asio/io_context.hpp>
#include <gtest/gtest.h>

namespace lode::serve {
namespace {

using asio::ip::tcp;

/// Connections whose clients never close.
class RefusalsTest : public testing::Test {
 protected:
  tcp::socket connection() {
    clients_.emplace_back(context_).connect(acceptor_.local_endpoint());
    return acceptor_.accept();
  }

  asio::io_context context_;
  tcp::acceptor acceptor_{context_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  std::vector<tcp::socket> clients_;
  Refusals refusals_;
};

TEST_F(RefusalsTest, limitTheWaitingConnections) {
  for (size_t i = 0; i < Refusals::kMost + 10; ++i) refusals_.refuse(connection(), {}, {});
  EXPECT_EQ(refusals_.size(), Refusals::kMost);
}

TEST_F(RefusalsTest, limitTheHandshakesUnderTls) {
  const auto tls = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  for (size_t i = 0; i < Refusals::kMostHandshakes + 10; ++i)
    refusals_.refuseUnderTls(connection(), tls, {}, {});
  EXPECT_EQ(refusals_.size(), Refusals::kMostHandshakes);
}

TEST_F(RefusalsTest, closeAfterTheirLingerTime) {
  refusals_.refuse(connection(), {}, {});
  refusals_.sweep(Refusals::Clock::time_point(Refusals::kLinger) - std::chrono::milliseconds(1));
  EXPECT_EQ(refusals_.size(), 1u);
  refusals_.sweep(Refusals::Clock::time_point(Refusals::kLinger));
  EXPECT_EQ(refusals_.size(), 0u);
}

TEST_F(RefusalsTest, forgetAConnectionOnceItHasClosed) {
  refusals_.refuse(connection(), {}, {});
  clients_.clear();
  acceptor_.close();
  refusals_.sweep({});
  EXPECT_EQ(refusals_.size(), 0u);
}

}  // namespace
}  // namespace lode::serve
