#include "server/serve/net/listener.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::serve {
namespace {

TEST(ListenAddress, isAHostAndAPort) {
  EXPECT_EQ(parseListenAddress("127.0.0.1:80").host, "127.0.0.1");
  EXPECT_EQ(parseListenAddress("127.0.0.1:80").port, 80);
  EXPECT_EQ(parseListenAddress("[::1]:65535").host, "::1");
  EXPECT_EQ(parseListenAddress("[::1]:65535").port, 65535);
  EXPECT_EQ(parseListenAddress("localhost:0").port, 0);
}

TEST(ListenAddress, hasTheDefaultPortIfNoneIsNamed) {
  EXPECT_EQ(parseListenAddress("localhost").port, 7400);
  EXPECT_EQ(parseListenAddress("[::1]").port, 7400);
}

TEST(ListenAddress, refusesInvalidAddresses) {
  for (const char* text : {"", ":7400", "host:", "host:x", "host:1x", "host:65536", "host:-1", "::1", "[::1",
                           "7455", "7455:7400", "[::1]7400", "[]:1"})
    EXPECT_THROW(parseListenAddress(text), Error) << text;
}

}  // namespace
}  // namespace lode::serve
